#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "reconstruct/fused/fused_engine.h"
#include "reconstruct/gpu.h"
#include "reconstruct/gpu/gpu_stages.h"

namespace slipstream {

/// Device memory for the scans in progress, reused from scan to scan.
struct GpuScanMemory {
  /// Buffers for the rows or scans of one submission.
  struct Slot {
    GpuBuffer frames, stages, between, output, packed;
    GpuRun run;
  };
  /// One per submission if `resident`, else up to two: one uploads while the other computes.
  std::vector<Slot> slots{};
  /// Keeps frames and results on the device, and uploads only once: times the device alone.
  bool resident = false;
};

/// The fused pass on a GPU: the same stages in shaders, four pixels per invocation, with the same
/// accuracy. Splits large images into parts of whole rows that fit the largest buffer, and computes
/// small ones together; copies overlap with computation. Thread-safe if each thread has its own
/// output and memory.
struct GpuEngine {
  static constexpr std::size_t pixels_at_once = std::size_t{1} << 21;

  /// Returns nullopt if gpu_stages does. `pixels`: size of a part; smaller if the device's buffers
  /// are too small. Throws as Gpu::open does.
  static std::optional<GpuEngine> make(const FusedEngine& fused, std::optional<int> device,
                                       std::size_t pixels = pixels_at_once);

  /// As FusedEngine's. Also throws GpuError if the device fails; the output is then undefined.
  void operator()(const FrameViews& frames, const Outputs& output, GpuScanMemory& memory,
                  const Image<float>* coarse = nullptr) const;
  /// Several scans at once, with the same bit depth and the same kind of outputs.
  void operator()(std::span<const FrameViews> scans, std::span<const Outputs> outputs,
                  GpuScanMemory& memory, const Image<float>* coarse = nullptr) const;

  /// Rows of the image that become results, and rows read, including their neighbours.
  struct Part {
    int first, last, first_seen, last_seen;
    GpuBuffer rays;
  };

  FusedEngine fused;
  GpuProgramText text;
  std::shared_ptr<const Gpu> gpu;
  std::vector<Part> parts{};
  Size largest{};            ///< of the parts
  std::size_t together = 1;  ///< scans computed at once, if that many are given
  GpuProgram coordinates_of_8_bits{}, coordinates_of_16_bits{}, points;
  std::vector<GpuProgram> vote{};  ///< one per task; empty without a cue

 private:
  GpuEngine(const FusedEngine& of, GpuProgramText program, std::shared_ptr<const Gpu> device,
            std::size_t pixels);
};

}  // namespace slipstream
