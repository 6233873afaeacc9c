#include "slipstream/reconstruct/engine.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/decode/band_unwrapper.h"
#include "slipstream/decode/frame_adapter.h"
#include "slipstream/decode/frame_motion.h"
#include "slipstream/frames/merged_exposures.h"
#include "slipstream/reconstruct/fused/fused_engine.h"
#include "slipstream/reconstruct/gpu/gpu_engine.h"
#include "slipstream/reconstruct/pipeline.h"

namespace slipstream {
namespace {

void pack(const Cloud& cloud, PackedPoints& points) {
  const std::array values{std::pair(&cloud.x, &points.x), std::pair(&cloud.y, &points.y),
                          std::pair(&cloud.z, &points.z),
                          std::pair(&cloud.intensity, &points.intensity)};
  for (const auto& [from, to] : values) {
    if (to->size() != cloud.size()) *to = Image<float>(cloud.size(), uninitialised);
    points.count = 0;
    for (std::size_t i = 0; i < from->pixel_count(); ++i) {
      if (cloud.validity.begin()[i] == Validity::valid)
        to->begin()[points.count++] = from->begin()[i];
    }
  }
}

template <class Body>
void for_each_index(Size size, const Body& body) {
  for_each_row(size.height, [&](int row) {
    const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(size.width);
    for (std::size_t i = first; i < first + static_cast<std::size_t>(size.width); ++i) body(i);
  });
}

/// One scale of brightness for all pixels: that of the shortest exposure.
void divide_by_gain(const FrameViews& frames, Image<float>& intensity) {
  if (!frames.merged()) return;
  const auto& gain = frames.gain();
  for_each_row(intensity.height(), [&](int row) {
    std::transform(intensity.row(row), intensity.row(row) + intensity.width(), gain.row(row),
                   intensity.row(row), std::divides<>());
  });
}

/// With the frames of a cycle and more as one window; and with lenses and a pose, where nobody has
/// measured any: maps are the same with all of them.
EngineSetup as_reconstructed(EngineSetup setup) {
  setup.sequence = merged_sequence(std::move(setup.sequence));
  Scanner& scanner = setup.scanner;
  if (has_geometry(scanner)) return setup;
  setup.settings.nearest.reset();  // depths without a geometry say nothing
  constexpr int fine_enough = 1 << 14;
  if (scanner.projector.size == Size{}) scanner.projector.size = {fine_enough, fine_enough};
  for (Lens* const lens : {&scanner.camera, &scanner.projector}) {
    const auto [width, height] = lens->size;
    lens->intrinsic << width, 0, 0.5 * width, 0, width, 0.5 * height, 0, 0, 1;
  }
  scanner.translation = {-100, -100, 0};
  return setup;
}

}  // namespace

/// What copies of an engine share.
struct Engine::Tables {
  explicit Tables(const EngineSetup& of)
      : setup(of), complete(as_reconstructed(of)), corrections(phase_corrections(of)) {
    require_reconstructible(complete);
    raise_least_modulation(complete);
    noise = depth_noise(complete);
    const Band& band = measuring_band(complete.sequence.strategy.layout());
    if (MotionMeasurement::is_possible(band)) measure_motion.emplace(band);
    if (setup.settings.engine != EngineKind::reference) {
      fused = FusedEngine::make(complete, corrections);
    }
    if (fused && setup.settings.engine == EngineKind::gpu) {
      try {
        gpu = GpuEngine::make(*fused, setup.settings.gpu);
      } catch (const GpuError& error) {  // too small for such pictures: the processor is not
        give_up_gpu(error);
      }
    }
    if (!fused || fused->wants_coarse()) static_cast<void>(reference());
  }

  /// Its tables take long to build: they are when they are first wanted.
  const ReferenceEngine& reference() {
    std::call_once(once, [this] { built.emplace(complete, corrections); });
    return *built;
  }
  /// The processor computes from now on, for all copies.
  void give_up_gpu(const GpuError& error) {
    if (error.why == GpuFailure::lost && gpu) gpu->device().lose();
    std::call_once(gave_up_gpu, [&] {
      gpu_failure = error.what();
      gpu_failed = true;
    });
  }
  /// In grey levels of the frames.
  [[nodiscard]] DepthNoise noise_for(const FrameViews& frames) const {
    DepthNoise scaled = noise;
    scaled.noise *= static_cast<float>(frames.full_scale() / 255);
    return scaled;
  }
  /// The most noise that a pixel has.
  [[nodiscard]] double noise_variance_of(const FrameViews& frames) const {
    const double grey_level = frames.full_scale() / 255;
    return noise_variance_at(255, cue_settings(complete).noise_variance,
                             setup.scanner.photometry.noise_gain) *
           grey_level * grey_level;
  }
  void require_geometry() const {
    if (!has_geometry(setup.scanner)) throw Error("without a scanner frames give maps, no points");
  }
  [[nodiscard]] bool is_fused(const FrameViews& frames) const {
    return fused && frames.quantised();
  }
  [[nodiscard]] bool is_on_gpu() const { return gpu && !gpu_failed; }

  EngineSetup setup;
  /// See as_reconstructed; with the modulation that its cue needs.
  EngineSetup complete;
  PhaseCorrections corrections;
  DepthNoise noise;                                 ///< of frames of 8 bits
  std::optional<MotionMeasurement> measure_motion;  ///< of windows of more than a cycle
  std::optional<FusedEngine> fused;
  std::optional<GpuEngine> gpu;
  std::once_flag gave_up_gpu;
  std::string gpu_failure;  ///< once gpu_failed
  std::atomic<bool> gpu_failed = false;
  std::once_flag once;
  std::optional<ReferenceEngine> built;
};

struct Engine::Memory {
  explicit Memory(const EngineSetup& setup) : adapt(setup.sequence), clean(setup.settings.clean) {}

  FusedMemory fused;
  GpuScanMemory gpu;
  FrameAdapter adapt;
  Image<float> modulation;
  std::optional<Cloud> cloud;  ///< whose points are packed; an empty one allocates
  Image<float> coarse;         ///< coordinates whose orders the picture gives
  Maps phases;                 ///< by which it does
  DepthOrders orders;
  FrameMotion motion;
  Cleaner clean;
};

Engine::Engine(const EngineSetup& setup)
    : tables_(std::make_shared<Tables>(setup)), memory_(std::make_unique<Memory>(setup)) {}

Engine::Engine(const Scanner& scanner, const Sequence& sequence,
               const ReconstructSettings& settings)
    : Engine(EngineSetup{scanner, sequence, settings}) {}

Engine::Engine(const Engine& other)
    : tables_(other.tables_), memory_(std::make_unique<Memory>(other.setup())) {}

Engine::Engine(Engine&& other) noexcept = default;

Engine& Engine::operator=(Engine other) noexcept {
  std::swap(tables_, other.tables_);
  std::swap(memory_, other.memory_);
  return *this;
}

Engine::~Engine() = default;

const EngineSetup& Engine::setup() const {
  return tables_->setup;
}

const FrameViews& Engine::merged(const FrameViews& frames) {
  return memory_->adapt(frames);
}

ValidityCounts Engine::run(const FrameViews& given, const Outputs& outputs) {
  Memory& memory = *memory_;
  if (outputs.makes_points()) tables_->require_geometry();
  const FrameViews& frames = merged(given);
  const bool packs = tables_->is_fused(frames) && !tables_->is_on_gpu() && !frames.merged() &&
                     !tables_->measure_motion;
  Outputs made = outputs;
  if (outputs.points != nullptr && !packs) {
    if (!memory.cloud) memory.cloud.emplace();
    made = {.cloud = &*memory.cloud};
  }
  if (outputs.cloud != nullptr && outputs.maps == nullptr && memory.clean.wants_modulation()) {
    made.modulation = &memory.modulation;
  }
  compute(frames, made);
  leave_out_moved(frames, made);
  if (made.cloud == nullptr) return {};
  divide_by_gain(frames, made.cloud->intensity);
  if (outputs.points != nullptr) {
    pack(*made.cloud, *outputs.points);
    return {};
  }
  const auto& modulation = outputs.maps != nullptr ? outputs.maps->modulation : memory.modulation;
  return memory.clean(*made.cloud, modulation, tables_->noise_for(frames));
}

void Engine::compute(const FrameViews& frames, const Outputs& outputs) {
  if (!tables_->is_fused(frames)) return tables_->reference().run(frames, outputs);
  if (tables_->fused->wants_coarse()) return compute_by_picture(frames, outputs);
  run_pass(frames, outputs, nullptr);
}

/// On the GPU, or where it has failed in the fused pass.
void Engine::run_pass(const FrameViews& frames, const Outputs& outputs,
                      const Image<float>* coarse) {
  if (tables_->is_on_gpu()) {
    try {
      return (*tables_->gpu)(frames, outputs, memory_->gpu, coarse);
    } catch (const GpuError& error) {  // the same comes from the processor
      tables_->give_up_gpu(error);
    }
  }
  memory_->gpu.slots.clear();
  (*tables_->fused)(frames, outputs, memory_->fused, coarse);
}

/// First the coordinates whose orders the picture gives, then what follows from them; of pixels
/// without one, why, where that is known.
void Engine::compute_by_picture(const FrameViews& frames, const Outputs& outputs) {
  Memory& memory = *memory_;
  const DepthUnwrapper* const by_depth = tables_->reference().by_depth();
  if (by_depth == nullptr) {
    convert(tables_->reference().maps(frames).coordinate, memory.coarse);
  } else {
    if (memory.coarse.size() != frames.size()) memory.coarse = Image<float>(frames.size());
    run_pass(frames, {.maps = &memory.phases}, &memory.coarse);
    const Image<float>& phase = memory.phases.wrapped_phase;
    (*by_depth)(phase, memory.phases.modulation, frames.full_scale(), memory.orders);
    by_depth->unwrap(phase, memory.orders.order, memory.coarse);
  }
  run_pass(frames, outputs, &memory.coarse);
  const auto say_why = [&](Image<Validity>& validity) {
    for_each_index(validity.size(), [&](std::size_t i) {
      Validity& pixel = validity.begin()[i];
      const bool unmeasured = pixel == Validity::too_dark || pixel == Validity::saturated;
      if (unmeasured || !std::isnan(memory.coarse.begin()[i])) return;
      pixel = by_depth == nullptr ? Validity::doubtful_order : memory.orders.validity.begin()[i];
    });
  };
  if (outputs.cloud != nullptr) say_why(outputs.cloud->validity);
  if (outputs.depth != nullptr) say_why(outputs.depth->validity);
}

void Engine::leave_out_moved(const FrameViews& frames, const Outputs& outputs) {
  if (!tables_->measure_motion) return;
  FrameMotion& motion = memory_->motion;
  (*tables_->measure_motion)(frames, motion);
  constexpr double deviations = 5;
  const auto limit = static_cast<float>(deviations * std::sqrt(tables_->noise_variance_of(frames)));
  const auto leave_out = [&](Validity& pixel, auto&... depths) {
    if (pixel != Validity::valid) return;
    pixel = Validity::moved;
    ((depths = std::numeric_limits<float>::quiet_NaN()), ...);
  };
  for_each_index(motion.unexplained.size(), [&](std::size_t i) {
    if (!(motion.unexplained.begin()[i] > limit)) return;
    if (Cloud* const cloud = outputs.cloud) {
      leave_out(cloud->validity.begin()[i], cloud->x.begin()[i], cloud->y.begin()[i],
                cloud->z.begin()[i]);
    }
    if (Depth* const depth = outputs.depth) {
      leave_out(depth->validity.begin()[i], depth->z.begin()[i]);
    }
    if (outputs.depth16 != nullptr) outputs.depth16->begin()[i] = 0;
  });
  if (outputs.maps != nullptr) std::swap(outputs.maps->motion, motion.speed);
}

double Engine::moving_share(const FrameViews& frames) const {
  if (!tables_->measure_motion) return 0;
  const double grey_level = frames.full_scale() / 255;
  return tables_->measure_motion->moving_share(
      frames, tables_->complete.settings.minimum_modulation * grey_level,
      tables_->noise_variance_of(frames));
}

Uncertainty Engine::uncertainty(const Cloud& cloud, const Maps& maps, const FrameViews& given) {
  tables_->require_geometry();
  return uncertainty_of(cloud, maps, tables_->complete, merged(given).full_scale());
}

std::string Engine::backend_for(const FrameViews& frames) {
  if (!tables_->is_fused(frames)) return tables_->reference().method_for(frames);
  return tables_->is_on_gpu() ? "gpu" : "fused";
}

std::string Engine::gpu_failure() const {
  return tables_->gpu_failed ? tables_->gpu_failure : "";
}

EngineSetup setup_for(const Scan& scan, const ReconstructSettings& settings) {
  if (!scan.scanner) throw Error("the scan has no scanner; a calibration file says one");
  EngineSetup setup{
      completed(*scan.scanner, "the scanner", scan.frames.size(), scan.sequence.projector),
      scan.sequence, settings};
  require_ambient_known(setup, "the scanner");
  return setup;
}

Cloud reconstruct(const Scan& scan, const ReconstructSettings& settings) {
  Cloud cloud;
  Engine(setup_for(scan, settings)).cloud(scan.frames, cloud);
  return cloud;
}

}  // namespace slipstream
