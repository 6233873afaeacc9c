#pragma once

#include "slipstream/reconstruct/fused/fused_engine.h"
#include "slipstream/reconstruct/gpu.h"
#include "slipstream/reconstruct/gpu/gpu_stages.h"

namespace slipstream {

/// Memory of the device for what is computed at a time, kept from scan to scan.
struct GpuScanMemory {
  /// For the rows, or the scans, that are computed at once.
  struct Slot {
    GpuBuffer frames, stages, between, output, packed;
    GpuRun run;
  };
  /// Two where there are several such: frames of one are uploaded while the other is computed. One
  /// for each where they stay.
  std::vector<Slot> slots{};
  /// Frames and results stay on the device, and nothing but the first scans are uploaded: what it
  /// takes by itself.
  bool resident = false;
};

/// What the fused pass computes, on a GPU: the same stages in shaders, four pixels for each
/// invocation, within the same bounds. Large pictures are cut into parts of whole rows that fit the
/// largest buffer, small ones computed together; copies overlap with computing. Thread-safe with an
/// output and memory for each thread.
struct GpuEngine {
  static constexpr std::size_t pixels_at_once = std::size_t{1} << 21;

  /// None where gpu_stages has none. Parts have about so many pixels, or fewer where the device's
  /// buffers are too small. Throws what Gpu::open throws.
  static std::optional<GpuEngine> make(const FusedEngine& fused, std::optional<int> device,
                                       std::size_t pixels = pixels_at_once);

  /// As FusedEngine's. Throws Error as it does, GpuError where the device fails:
  /// the output is then undefined.
  void operator()(const FrameViews& frames, const Outputs& output, GpuScanMemory& memory,
                  const Image<float>* coarse = nullptr) const;
  /// Of several scans at once, whose frames have as many bits, and of which the same is wanted.
  void operator()(std::span<const FrameViews> scans, std::span<const Outputs> outputs,
                  GpuScanMemory& memory, const Image<float>* coarse = nullptr) const;

  /// Rows of the picture: those that become results, and with the neighbours that confirm them.
  struct Part {
    int first, last, first_seen, last_seen;
    GpuBuffer rays;
  };

  FusedEngine fused;
  GpuProgramText text;
  std::shared_ptr<const Gpu> gpu;
  std::vector<Part> parts{};
  Size largest{};            ///< of the parts
  std::size_t together = 1;  ///< scans that are computed at once, where there are so many
  GpuProgram coordinates_of_8_bits{}, coordinates_of_16_bits{}, points;
  std::vector<GpuProgram> vote{};  ///< its tasks, where a cue asks for one

 private:
  GpuEngine(const FusedEngine& of, GpuProgramText program, std::shared_ptr<const Gpu> device,
            std::size_t pixels);
};

}  // namespace slipstream
