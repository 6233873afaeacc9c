#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "slipstream/base/error.h"

// Programs on a graphics unit, or on Mesa's drivers that are software, by Vulkan. What the programs
// compute is the affair of who hands them in.
namespace slipstream {

/// A device, as its driver describes it.
struct GpuDescription {
  std::string name;
  std::string driver;
  bool software = false;     ///< computed by this machine's own cores
  bool discrete = false;     ///< a card of its own, with memory of its own
  std::uint64_t memory = 0;  ///< bytes of its own
};

/// The devices of this machine, in the order of its drivers; none without Vulkan.
std::vector<GpuDescription> gpu_devices();

enum class GpuFailure {
  lost,       ///< it fails whoever asks, or does not answer; what it held is gone
  no_memory,  ///< left for what was asked for
  too_small,  ///< it never can
};

/// Why a device did not do its work, which can be done elsewhere.
class GpuError : public WorldError {
 public:
  GpuError(GpuFailure why_, const std::string& text) : WorldError(text), why(why_) {}
  GpuFailure why;
};

/// Where memory lies that a device computes on.
enum class GpuMemory {
  device,    ///< out of reach of the host
  upload,    ///< written by the host, in the device's own memory where the two share some
  download,  ///< read by the host
};

class Gpu;

/// Memory of a device. Throws GpuError where there is none left, or none so large at a time.
class GpuBuffer {
 public:
  GpuBuffer(std::shared_ptr<const Gpu> gpu, std::size_t bytes, GpuMemory memory);

  [[nodiscard]] std::size_t size() const { return size_; }
  /// As the host sees it; null for GpuMemory::device.
  [[nodiscard]] std::byte* data() const { return data_; }

 private:
  friend class GpuRun;
  struct Parts;
  std::size_t size_ = 0;
  std::byte* data_ = nullptr;
  std::shared_ptr<Parts> parts_;
};

/// A compute shader, ready for a device.
class GpuProgram {
 public:
  /// Buffers that a program may have, at the bindings 0, 1, ...
  static constexpr std::uint32_t most_buffers = 6;
  /// Invocations of a work group: local_size_x of every shader.
  static constexpr std::uint32_t group_size = 64;

  GpuProgram() = default;  ///< none
  /// `constants`: the specialisation constants 0, 1, ... Throws GpuError.
  GpuProgram(std::shared_ptr<const Gpu> gpu, std::span<const std::uint32_t> spirv,
             std::span<const std::uint32_t> constants);

 private:
  friend class GpuRun;
  struct Parts;
  std::shared_ptr<Parts> parts_;
};

/// Runs programs one after another on the same buffers. It keeps both until they are done, and
/// waits for that at its end; those of a device that does not answer are never freed. For one
/// thread.
class GpuRun {
 public:
  /// Of every device.
  static constexpr std::uint32_t most_layers = 65535;

  explicit GpuRun(std::shared_ptr<const Gpu> gpu);

  /// Each program with at least so many invocations, and that for each of `layers`:
  /// gl_WorkGroupID.z. The last start must have been waited for. Throws GpuError.
  void start(std::span<const GpuBuffer* const> buffers, std::span<const GpuProgram* const> programs,
             std::uint64_t invocations, std::uint32_t layers = 1);
  /// Until all that was started is computed and the host sees it. Throws GpuError.
  void wait();

 private:
  struct Parts;
  std::shared_ptr<Parts> parts_;
};

/// A device in use. What was made of it keeps it. Thread-safe.
class Gpu {
 public:
  /// The device of that number in gpu_devices(), else the first that is discrete, or not software,
  /// or at all; shared by all who open it. Throws WorldError where there is none such, GpuError
  /// where it cannot be used.
  static std::shared_ptr<const Gpu> open(std::optional<int> number);

  [[nodiscard]] const GpuDescription& description() const { return description_; }
  /// The largest buffer.
  [[nodiscard]] std::size_t most_bytes() const { return most_bytes_; }
  /// It fails from now on as a device does that the driver has lost; open gives another.
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
