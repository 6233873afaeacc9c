#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "slipstream/error.h"

// Compute shaders on a GPU, or on Mesa's software drivers, through Vulkan; supplied by the caller.
namespace slipstream {

/// A device as described by its driver.
struct GpuDescription {
  std::string name;
  std::string driver{};
  bool software = false;     ///< runs on the CPU
  bool discrete = false;     ///< a separate card with its own memory
  std::uint64_t memory = 0;  ///< dedicated memory, bytes
};

/// The devices of this machine, in driver order; empty without Vulkan.
std::vector<GpuDescription> gpu_devices();

enum class GpuFailure {
  lost,       ///< the device failed or does not answer; its memory is lost
  no_memory,  ///< out of device memory
  too_small,  ///< the device can never do it
};

/// A device failure; another engine can do the work.
class GpuError : public WorldError {
 public:
  GpuError(GpuFailure why_, const std::string& text) : WorldError(text), why(why_) {}
  GpuFailure why;
};

/// Where a buffer is allocated.
enum class GpuMemory {
  device,    ///< not visible to the host
  upload,    ///< written by the host; in device memory if the host can access that
  download,  ///< read by the host
};

class Gpu;

/// Device memory. Throws GpuError if there is not enough, or the buffer exceeds the device's limit.
class GpuBuffer {
 public:
  GpuBuffer(std::shared_ptr<const Gpu> gpu, std::size_t bytes, GpuMemory memory);

  [[nodiscard]] std::size_t size() const { return size_; }
  /// Address on the host; null for GpuMemory::device.
  [[nodiscard]] std::byte* data() const { return data_; }

 private:
  friend class GpuRun;
  struct Parts;
  std::size_t size_ = 0;
  std::byte* data_ = nullptr;
  std::shared_ptr<Parts> parts_;
};

/// A compute shader, compiled for a device.
class GpuProgram {
 public:
  /// Most buffers per program, at bindings 0, 1, ...
  static constexpr std::uint32_t most_buffers = 6;
  /// Invocations per work group: local_size_x of every shader.
  static constexpr std::uint32_t group_size = 64;

  GpuProgram() = default;  ///< empty
  /// `constants`: specialisation constants 0, 1, ... Throws GpuError.
  GpuProgram(std::shared_ptr<const Gpu> gpu, std::span<const std::uint32_t> spirv,
             std::span<const std::uint32_t> constants);

 private:
  friend class GpuRun;
  struct Parts;
  std::shared_ptr<Parts> parts_;
};

/// Runs programs one after another on the same buffers. Keeps both until the programs are done; the
/// destructor waits for that. If the device does not answer, they are never freed. For one thread.
class GpuRun {
 public:
  /// Supported by every device.
  static constexpr std::uint32_t most_layers = 65535;

  explicit GpuRun(std::shared_ptr<const Gpu> gpu);

  /// Runs each program with at least this many invocations per layer; the layer is
  /// gl_WorkGroupID.z. Call wait() before the next start. Throws GpuError.
  void start(std::span<const GpuBuffer* const> buffers, std::span<const GpuProgram* const> programs,
             std::uint64_t invocations, std::uint32_t layers = 1);
  /// Waits until all that was started is computed and visible to the host. Throws GpuError.
  void wait();

 private:
  struct Parts;
  std::shared_ptr<Parts> parts_;
};

/// An open device; everything created from it keeps it open. Thread-safe.
class Gpu {
 public:
  /// Opens this device of gpu_devices(); by default the first discrete one, else the first that is
  /// not software, else the first. All callers share it. Throws WorldError if there is no such
  /// device, GpuError if it cannot be used.
  static std::shared_ptr<const Gpu> open(std::optional<int> number);

  [[nodiscard]] const GpuDescription& description() const { return description_; }
  /// Size of the largest buffer.
  [[nodiscard]] std::size_t most_bytes() const { return most_bytes_; }
  /// Treats the device as lost from now on; open() returns a new one.
  void lose() const { lost_ = true; }

 private:
  friend class GpuBuffer;
  friend class GpuProgram;
  friend class GpuRun;
  struct Parts;
  explicit Gpu(int number);
  GpuDescription description_;
  std::size_t most_bytes_ = 0;
  mutable std::atomic<bool> lost_ = false;
  std::shared_ptr<Parts> parts_;
};

}  // namespace slipstream
