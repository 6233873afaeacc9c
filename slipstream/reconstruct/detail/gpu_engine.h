#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "slipstream/capture/frame_views.h"
#include "slipstream/gpu/gpu.h"
#include "slipstream/reconstruct/detail/fused_engine.h"
#include "slipstream/reconstruct/detail/gpu_stages.h"

namespace slipstream {

/// Memory of the device for one scan at a time, kept from scan to scan.
struct GpuScanMemory {
  struct Parts {
    GpuBuffer frames, stages, between, output, packed;
    GpuRun run;
  };
  std::optional<Parts> parts{};
};

/// What the fused pass computes, on a GPU: the same stages in shaders, a pixel for each invocation,
/// and the same bounds against the equations. Thread-safe with an output and memory for each
/// thread.
class GpuEngine {
 public:
  /// None where gpu_stages has none. Throws what Gpu::open throws.
  static std::optional<GpuEngine> make(const FusedEngine& fused, std::optional<int> device);

  /// As FusedEngine's, of frames that require_frames takes. Throws GpuError where the device fails:
  /// the output is then undefined.
  void operator()(const FrameViews& frames, const FusedOutput& output, GpuScanMemory& memory,
                  const Image<float>* coarse = nullptr) const;

  [[nodiscard]] const Gpu& device() const { return *gpu_; }

 private:
  GpuEngine(const FusedEngine& fused, GpuProgramText text, std::shared_ptr<const Gpu> gpu);

  [[nodiscard]] GpuScanMemory::Parts memory_for(std::size_t frame_bytes, std::size_t planes) const;

  ReconstructSettings settings_;
  std::vector<SinusoidStage> sinusoids_;  ///< of each band
  GpuProgramText text_;
  std::shared_ptr<const Gpu> gpu_;
  GpuBuffer rays_;
  GpuProgram coordinates_of_8_bits_, coordinates_of_16_bits_, points_;
};

}  // namespace slipstream
