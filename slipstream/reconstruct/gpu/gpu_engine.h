#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "slipstream/frames/frame_set.h"
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
/// invocation, and the same bounds against the equations. Large pictures are cut into parts of
/// whole rows, and small ones computed together, in one submission. Either way copies overlap with
/// computing, and the device's largest buffer is kept to. Thread-safe with an output and memory for
/// each thread.
class GpuEngine {
 public:
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

  [[nodiscard]] const Gpu& device() const { return *gpu_; }

 private:
  /// Rows of the picture: those that become results, and with the neighbours that confirm them.
  struct Part {
    int first, last, first_seen, last_seen;
    GpuBuffer rays;
  };
  struct Job;
  struct Step;

  GpuEngine(const FusedEngine& fused, GpuProgramText text, std::shared_ptr<const Gpu> gpu,
            std::size_t pixels);

  [[nodiscard]] GpuScanMemory::Slot slot_for(const Job& job, bool resident) const;
  [[nodiscard]] Job job_for(std::span<const FrameViews> scans, std::span<const Outputs> outputs,
                            const Image<float>* coarse) const;
  static void upload(const Step& step, const Job& job, const GpuBuffer& to);
  void start(const Step& step, Job& job, GpuScanMemory::Slot& slot) const;
  static void collect(const Step& step, const Job& job, const GpuScanMemory::Slot& slot);

  ReconstructSettings settings_;
  int frames_;
  std::vector<SinusoidStage> sinusoids_;  ///< of each band
  GpuProgramText text_;
  std::shared_ptr<const Gpu> gpu_;
  std::vector<Part> parts_;
  Size largest_;              ///< of the parts
  std::size_t together_ = 1;  ///< scans that are computed at once, where there are so many
  GpuProgram coordinates_of_8_bits_, coordinates_of_16_bits_, points_;
  std::vector<GpuProgram> vote_;  ///< its tasks, where a cue asks for one
  CueLimits cue_limits_;          ///< of frames of 8 bits
};

}  // namespace slipstream
