#pragma once

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

/// The devices of this machine, in the order of its drivers; none where there is no driver, or
/// where the library was built without Vulkan.
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
  GpuBuffer(GpuBuffer&&) noexcept;
  GpuBuffer& operator=(GpuBuffer&&) noexcept;
  ~GpuBuffer();

  [[nodiscard]] std::size_t size() const;
  /// As the host sees it; null for GpuMemory::device.
  [[nodiscard]] std::byte* data() const;

 private:
  friend class GpuRun;
  struct Parts;
  std::shared_ptr<Parts> parts_;
};

/// A compute shader, ready for a device.
class GpuProgram {
 public:
  /// Buffers that a program may have, at the bindings 0, 1, ...
  static constexpr std::uint32_t most_buffers = 6;
  /// Invocations of a work group: local_size_x of every shader.
  static constexpr std::uint32_t group_size = 64;

  /// `constants`: the specialisation constants 0, 1, ... Throws GpuError.
  GpuProgram(std::shared_ptr<const Gpu> gpu, std::span<const std::uint32_t> spirv,
             std::span<const std::uint32_t> constants);
  GpuProgram(GpuProgram&&) noexcept;
  GpuProgram& operator=(GpuProgram&&) noexcept;
  ~GpuProgram();

 private:
  friend class GpuRun;
  struct Parts;
  std::shared_ptr<Parts> parts_;
};

/// Runs programs one after another on the same buffers. It keeps both until it has, which it waits
/// for before it ends; those that a device is at which no longer answers are never freed. One
/// thread uses it at a time.
class GpuRun {
 public:
  /// Of every device.
  static constexpr std::uint32_t most_layers = 65535;

  explicit GpuRun(std::shared_ptr<const Gpu> gpu);
  GpuRun(GpuRun&&) noexcept;
  ~GpuRun();

  /// Each program with at least so many invocations, which tell those beyond by themselves, and
  /// that for each of `layers`: gl_WorkGroupID.z. The last start has been waited for. Throws
  /// GpuError.
  void start(std::span<const GpuBuffer* const> buffers, std::span<const GpuProgram* const> programs,
             std::uint64_t invocations, std::uint32_t layers = 1);
  /// Until all that was started is computed and the host sees it. Throws GpuError.
  void wait();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// A device in use. What was made of it keeps it. Thread-safe.
class Gpu {
 public:
  /// The device of that number in gpu_devices(); without a number the first that is discrete, or
  /// else that is not software, or else the first. Who opens one that others use shares it. Throws
  /// WorldError where there is none such, GpuError where it cannot be used.
  static std::shared_ptr<const Gpu> open(std::optional<int> number);
  ~Gpu();

  [[nodiscard]] const GpuDescription& description() const;
  /// The largest buffer.
  [[nodiscard]] std::size_t most_bytes() const;
  /// From now on it fails whoever asks, as a device does that the driver has lost; open gives
  /// another. Called where it has failed, and by tests.
  void lose() const;

 private:
  friend class GpuBuffer;
  friend class GpuProgram;
  friend class GpuRun;
  struct Parts;
  explicit Gpu(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace slipstream
