#include "slipstream/reconstruct/engine.h"

#include <mutex>

#include <fmt/format.h>

#include "slipstream/base/numbers.h"
#include "slipstream/decode/band_unwrapper.h"
#include "slipstream/decode/frame_adapter.h"
#include "slipstream/decode/frame_motion.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/reconstruct/fused/fused_engine.h"
#include "slipstream/reconstruct/gpu/gpu_engine.h"
#include "slipstream/reconstruct/pipeline.h"

namespace slipstream {
namespace {

void pack(const Cloud& cloud, PackedPoints& points) {
  const std::array from{&cloud.x, &cloud.y, &cloud.z, &cloud.intensity};
  const std::array to{&points.x, &points.y, &points.z, &points.intensity};
  for (std::size_t k = 0; k < from.size(); ++k) {
    if (to[k]->size() != cloud.size()) *to[k] = Image<float>(cloud.size(), uninitialised);
    points.count = 0;
    for (std::size_t i = 0; i < from[k]->pixel_count(); ++i) {
      if (cloud.validity.begin()[i] == Validity::valid)
        to[k]->begin()[points.count++] = from[k]->begin()[i];
    }
  }
}

/// One scale of brightness for all pixels: that of the shortest exposure.
void divide_by_gain(const FrameViews& frames, Image<float>& intensity) {
  if (!frames.merged()) return;
  for_each_row(intensity.height(), [&](int row) {
    std::transform(intensity.row(row), intensity.row(row) + intensity.width(),
                   frames.gain().row(row), intensity.row(row), std::divides<>());
  });
}

std::string without_gpu(const GpuError& error) {
  return fmt::format("{}; the processor goes on", error.what());
}

std::string without_fused(const std::string& why) {
  return fmt::format("no fused engine: {}; the reference engine goes on", why);
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
    const EngineKind asked = setup.settings.engine;
    if (asked != EngineKind::reference && !setup.own_engine) {
      std::string why_not;
      fused = FusedEngine::make(complete, corrections, &why_not);
      if (!fused && asked == EngineKind::fused) fall_back(without_fused(why_not));
    }
    if (fused && asked == EngineKind::gpu) {
      try {
        gpu = GpuEngine::make(*fused, setup.settings.gpu);
      } catch (const GpuError& error) {  // too small for such pictures: the processor is not
        fall_back(without_gpu(error));
      }
    }
    if (!setup.own_engine && (!fused || fused->wants_coarse())) static_cast<void>(reference());
  }

  /// What computes such frames: what is asked for or, where that cannot, the next that can.
  [[nodiscard]] EngineKind engine_for(const FrameViews& frames) const {
    if (!fused || !frames.quantised()) return EngineKind::reference;
    return gpu && !fell_back ? EngineKind::gpu : EngineKind::fused;
  }
  /// Another engine computes from now on, for all copies.
  void fall_back(const std::string& why_not) {
    std::call_once(once_fallen_back, [&] {
      fallback_reason = why_not;
      fell_back = true;
    });
  }
  /// Its tables take long to build: they are when they are first wanted.
  const ReferenceEngine& reference() {
    std::call_once(once, [this] { built.emplace(complete, corrections); });
    return *built;
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

  EngineSetup setup;
  /// See as_reconstructed; with the modulation that its cue needs.
  EngineSetup complete;
  PhaseCorrections corrections;
  DepthNoise noise;                                 ///< of frames of 8 bits
  std::optional<MotionMeasurement> measure_motion;  ///< of windows of more than a cycle
  std::optional<FusedEngine> fused;
  std::optional<GpuEngine> gpu;
  std::once_flag once_fallen_back;
  std::string fallback_reason;  ///< once it fell back
  std::atomic<bool> fell_back = false;
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
    : tables_(std::make_shared<Tables>(setup)), memory_(std::make_shared<Memory>(setup)) {}

Engine::Engine(const Scanner& scanner, const Sequence& sequence,
               const ReconstructSettings& settings)
    : Engine(EngineSetup{scanner, sequence, settings}) {}

Engine::Engine(const Engine& other)
    : tables_(other.tables_), memory_(std::make_shared<Memory>(other.setup())) {}

Engine& Engine::operator=(Engine other) noexcept {
  std::swap(tables_, other.tables_);
  std::swap(memory_, other.memory_);
  return *this;
}

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
  const bool packs = tables_->engine_for(frames) == EngineKind::fused && !frames.merged() &&
                     !tables_->measure_motion;
  Outputs made = outputs;
  if (outputs.points != nullptr && !packs) {
    if (!memory.cloud) memory.cloud.emplace();
    made = {.cloud = &*memory.cloud};
  }
  if (outputs.cloud != nullptr && outputs.maps == nullptr && memory.clean.wants_modulation()) {
    made.modulation = &memory.modulation;
  }
  compute(frames, made, nullptr);
  leave_out_moved(frames, made);
  if (made.cloud == nullptr) return {};
  divide_by_gain(frames, made.cloud->intensity);
  if (outputs.points != nullptr) {
    pack(*made.cloud, *outputs.points);
    return {};
  }
  const auto& modulation = outputs.maps != nullptr ? outputs.maps->modulation : memory.modulation;
  DepthNoise noise = tables_->noise;
  noise.noise *= static_cast<float>(frames.full_scale() / 255);
  return memory.clean(*made.cloud, &modulation, noise);
}

/// By the engine chosen, else by the next that can.
void Engine::compute(const FrameViews& frames, const Outputs& outputs, const Image<float>* coarse) {
  if (setup().own_engine) return setup().own_engine->run(frames, outputs);
  const EngineKind kind = tables_->engine_for(frames);
  if (kind == EngineKind::reference) {
    if (setup().settings.engine == EngineKind::fused && !frames.quantised()) {
      tables_->fall_back(without_fused("it takes frames of 8 to 16 bits"));
    }
    return tables_->reference().run(frames, outputs);
  }
  if (tables_->fused->wants_coarse() && coarse == nullptr)
    return compute_by_picture(frames, outputs);
  if (kind == EngineKind::gpu) {
    try {
      return (*tables_->gpu)(frames, outputs, memory_->gpu, coarse);
    } catch (const GpuError& error) {  // the same comes from the processor
      if (error.why == GpuFailure::lost) tables_->gpu->gpu->lose();
      tables_->fall_back(without_gpu(error));
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
    compute(frames, {.maps = &memory.phases}, &memory.coarse);
    const Image<float>& phase = memory.phases.wrapped_phase;
    (*by_depth)(phase, memory.phases.modulation, frames.full_scale(), memory.orders);
    by_depth->unwrap(phase, memory.orders.order, memory.coarse);
  }
  compute(frames, outputs, &memory.coarse);
  const auto say_why = [&](Image<Validity>& validity) {
    for_each_pixel(validity.size(), [&](int column, int row) {
      Validity& pixel = validity(column, row);
      const bool unmeasured = pixel == Validity::too_dark || pixel == Validity::saturated;
      if (unmeasured || !std::isnan(memory.coarse(column, row))) return;
      pixel = by_depth == nullptr ? Validity::doubtful_order : memory.orders.validity(column, row);
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
  for_each_pixel(motion.unexplained.size(), [&](int column, int row) {
    if (!(motion.unexplained(column, row) > limit)) return;
    const auto leave_out = [&](Image<Validity>& validity, auto&... depths) {
      if (validity(column, row) != Validity::valid) return;
      validity(column, row) = Validity::moved;
      ((depths(column, row) = std::numeric_limits<float>::quiet_NaN()), ...);
    };
    if (Cloud* const cloud = outputs.cloud) {
      leave_out(cloud->validity, cloud->x, cloud->y, cloud->z);
    }
    if (Depth* const depth = outputs.depth) leave_out(depth->validity, depth->z);
    if (outputs.depth16 != nullptr) (*outputs.depth16)(column, row) = 0;
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
  if (setup().own_engine) return setup().own_engine->name;
  const EngineKind kind = tables_->engine_for(frames);
  if (kind == EngineKind::reference) return tables_->reference().method_for(frames);
  return kind == EngineKind::gpu ? "gpu" : "fused";
}

std::string Engine::fallback_reason() const {
  return tables_->fell_back ? tables_->fallback_reason : "";
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
