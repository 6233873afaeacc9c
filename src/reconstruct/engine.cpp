#include "slipstream/engine.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "base/throw_if-inl.h"
#include "decode/frame_adapter.h"
#include "decode/frame_motion.h"
#include "decode/phase_decoder.h"
#include "reconstruct/contrast.h"
#include "reconstruct/depth_unwrapper.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/fused/fused_engine.h"
#include "reconstruct/gpu/gpu_engine.h"
#include "reconstruct/pipeline.h"
#include "reconstruct/points.h"
#include "reconstruct/reflection.h"
#include "reconstruct/table_engine.h"
#include "response/correction.h"
#include "slipstream/frame_set.h"

namespace slipstream {
namespace {

void pack(const Cloud& cloud, PackedPoints& points) {
  const std::array from{&cloud.x, &cloud.y, &cloud.z, &cloud.intensity};
  const std::array to{&points.x, &points.y, &points.z, &points.intensity};

  // Plane by plane; each visits the same valid pixels, so that entries stay in step.
  for (std::size_t k = 0; k < from.size(); ++k) {
    if (to[k]->size() != cloud.size()) *to[k] = Image<float>(cloud.size(), uninitialised);

    points.count = 0;
    for (std::size_t i = 0; i < from[k]->pixel_count(); ++i) {
      if (cloud.validity.begin()[i] == Validity::valid)
        to[k]->begin()[points.count++] = from[k]->begin()[i];
    }
  }
}

/// Scales all pixels to the brightness of the shortest exposure.
void divide_by_gain(const FrameViews& frames, Image<float>& intensity) {
  if (!frames.merged()) return;
  for_each_row(intensity.height(), [&](int row) {
    std::transform(intensity.row(row), intensity.row(row) + intensity.width(),
                   frames.gain().row(row), intensity.row(row), std::divides<>());
  });
}

std::string without_gpu(std::string_view why) {
  return fmt::format("{}; continuing on the CPU", why);
}

std::string without_fused(const std::string& why) {
  return fmt::format("no fused engine: {}; using the reference engine", why);
}

std::string without_tables(const std::string& why) {
  return fmt::format("no table engine: {}; using the reference engine", why);
}

/// Frames of a motion window become one sequence. A scanner without geometry gets arbitrary lenses
/// and an arbitrary pose, on which maps do not depend.
EngineSetup as_reconstructed(EngineSetup setup) {
  setup.sequence = merged_sequence(std::move(setup.sequence));

  Scanner& scanner = setup.scanner;
  if (has_geometry(scanner)) return setup;

  setup.settings.nearest.reset();  // depths need a geometry

  // A projector of unknown size counts as fine enough for any pattern.
  constexpr int fine_enough = 1 << 14;
  if (scanner.projector.size == Size{}) scanner.projector.size = {fine_enough, fine_enough};

  // The focal length is the picture's width; the baseline is oblique, so that the scanner is valid
  // for patterns along either axis.
  for (Lens* const lens : {&scanner.camera, &scanner.projector}) {
    const auto [width, height] = lens->size;
    lens->intrinsic << width, 0, 0.5 * width, 0, width, 0.5 * height, 0, 0, 1;
  }
  scanner.translation = {-100, -100, 0};

  return setup;
}

}  // namespace

/// Shared by the copies of an engine.
struct Engine::Tables {
  explicit Tables(const EngineSetup& of)
      : setup(of), complete(as_reconstructed(of)), corrections(phase_corrections(of)) {
    // 1. The setup: without geometry only maps are possible.
    if (has_geometry(of.scanner)) {
      require_reconstructible(complete);
    } else {
      require_valid(complete);
    }
    raise_least_modulation(complete);
    noise = depth_noise(complete);

    const Band& band = measuring_band(complete.sequence.strategy.layout());
    if (MotionMeasurement::is_possible(band)) measure_motion.emplace(band);

    throw_if(rejects_reflection(of.settings.clean) &&
                 !shows_reflection(complete.sequence.strategy.layout()),
             "{}: these patterns do not show light from other surfaces; those with a "
             "finest band of 4 to 16 times the coarsest one's periods do, such as dual-frequency",
             complete.sequence.strategy.name());
    if (of.settings.correct_contrast) require_contrast_correctable(of);

    // 2. The fused pass, unless the reference or the caller's own engine was chosen.
    const ReconstructSettings& settings = setup.settings;
    if (settings.engine != EngineKind::reference && !settings.custom_engine) {
      std::string why_not;
      fused = FusedEngine::make(complete, corrections, &why_not);
      if (!fused) fall_back(without_fused(why_not));
    }

    // 3. The GPU runs the fused pass's stages, with its tables.
    if (fused && settings.engine == EngineKind::gpu) {
      try {
        gpu = GpuEngine::make(*fused, settings.gpu);
        if (!gpu) {
          fall_back(
              without_gpu("its shaders do not support this strategy, lens or number of frames"));
        }
      } catch (const GpuError& error) {  // the device is too small
        fall_back(without_gpu(error.what()));
      }
    }

    // 4. The table engine takes the reference engine's place where it can.
    if (settings.engine == EngineKind::reference && !settings.custom_engine &&
        has_geometry(of.scanner)) {
      std::string why_not;
      table_engine = TableEngine::make(complete, corrections, &why_not);
      if (!table_engine && settings.phase_method == PhaseMethod::tables) {
        fall_back(without_tables(why_not));
      }
    }

    // 5. The reference engine: now if every scan needs it, otherwise with the first scan that does.
    if (!settings.custom_engine && !table_engine && (!fused || fused->wants_coarse()))
      static_cast<void>(reference());
  }

  /// The chosen engine or, if it cannot process these frames, the next.
  [[nodiscard]] EngineKind engine_for(const FrameViews& frames) const {
    if (!fused || !frames.quantised()) return EngineKind::reference;
    return gpu && !fell_back ? EngineKind::gpu : EngineKind::fused;
  }

  /// Switches all copies to another engine from now on.
  void fall_back(const std::string& why_not) {
    std::call_once(once_fallen_back, [&] {
      fallback_reason = why_not;
      fell_back = true;
    });
  }
  /// Built on first use, because its tables take long.
  const ReferenceEngine& reference() {
    std::call_once(once, [this] { built.emplace(complete, corrections); });
    return *built;
  }
  /// Noise variance of the brightest pixels, in squared grey levels of the frames.
  [[nodiscard]] double noise_variance_of(const FrameViews& frames) const {
    const double grey_level = frames.full_scale() / 255;
    return noise_variance_at(255, cue_settings(complete).noise_variance,
                             setup.scanner.photometry.noise_gain) *
           grey_level * grey_level;
  }

  void require_geometry() const {
    if (!has_geometry(setup.scanner))
      throw Error("points require a scanner; without one, frames give only maps");
  }

  EngineSetup setup;
  /// See as_reconstructed; with the least modulation that the cue needs.
  EngineSetup complete;

  PhaseCorrections corrections;
  DepthNoise noise;                                 ///< for 8-bit frames
  std::optional<MotionMeasurement> measure_motion;  ///< for windows longer than a cycle

  std::optional<FusedEngine> fused;
  std::optional<GpuEngine> gpu;
  std::optional<TableEngine> table_engine;  ///< in place of the reference engine where it can be

  std::once_flag once_fallen_back;
  std::string fallback_reason;  ///< set when it falls back
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
  Maps maps;                   ///< from which light of other surfaces is found
  std::optional<Cloud> cloud;  ///< source of packed points; constructed when needed

  Image<float> coarse;  ///< coordinates with orders from the whole image
  Maps phases;          ///< from which these orders are found
  DepthOrders orders;

  FrameMotion motion;
  Cleaner clean;
  std::atomic<bool> unquantised = false;  ///< the newest frames, which no fused engine takes
  std::atomic<bool> not_bytes = false;    ///< the newest frames, which the table engine lacks
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

ValidityCounts Engine::run(const FrameViews& captured, const Outputs& outputs) {
  Memory& memory = *memory_;
  if (outputs.makes_points()) tables_->require_geometry();

  // 1. Packed points: the fused pass writes them itself, unless exposures are merged or pixels that
  //    moved must be left out. Otherwise they are packed from a whole cloud.
  const FrameViews& frames = merged(captured);
  const bool packs = tables_->engine_for(frames) == EngineKind::fused && !frames.merged() &&
                     !tables_->measure_motion;
  Outputs made = outputs;
  if (outputs.points != nullptr && !packs) {
    if (!memory.cloud) memory.cloud.emplace();
    made = {.cloud = &*memory.cloud};
  }

  // Cleaning may need maps or the modulation where they were not requested.
  const bool without_maps = outputs.cloud != nullptr && outputs.maps == nullptr;
  const ReconstructSettings& settings = setup().settings;
  if (without_maps && (rejects_reflection(settings.clean) || settings.correct_contrast)) {
    made.maps = &memory.maps;
  } else if (without_maps && memory.clean.wants_modulation()) {
    made.modulation = &memory.modulation;
  }

  // 2. Compute, and correct for motion, light of other surfaces, contrast
  //    and exposure.
  if (made.maps != nullptr) made.maps->contrast = {};  // of an earlier use
  compute(frames, made, nullptr);
  reject_moved(frames, made);
  if (outputs.cloud != nullptr) {
    reject_reflected(frames, made);
    if (settings.correct_contrast) correct_contrast(tables_->complete, *made.cloud, *made.maps);
  }

  if (made.cloud == nullptr) return {};
  made.cloud->frame.reset();  // of an earlier use
  divide_by_gain(frames, made.cloud->intensity);

  if (outputs.points != nullptr) {
    pack(*made.cloud, *outputs.points);
    return {};
  }

  // 3. Clean. The depth noise is for 8-bit frames; the modulation is in grey levels of these.
  const auto& modulation = made.maps != nullptr ? made.maps->modulation : memory.modulation;
  DepthNoise noise = tables_->noise;
  noise.noise *= static_cast<float>(frames.full_scale() / 255);
  return memory.clean(*made.cloud, &modulation, noise);
}

void Engine::compute(const FrameViews& frames, const Outputs& outputs, const Image<float>* coarse) {
  // The caller's own engine comes first.
  if (setup().settings.custom_engine) return setup().settings.custom_engine->run(frames, outputs);

  // Other layouts, lenses or frames: the tables or the reference engine.
  const EngineKind kind = tables_->engine_for(frames);
  memory_->unquantised = tables_->fused && !frames.quantised();
  memory_->not_bytes = tables_->table_engine && !TableEngine::takes(frames);

  if (kind == EngineKind::reference) {
    if (tables_->table_engine && TableEngine::takes(frames)) {
      return (*tables_->table_engine)(frames, outputs);
    }
    return tables_->reference().run(frames, outputs);
  }

  // Fringe orders that need the whole image are found first, in a pass of their own.
  if (tables_->fused->wants_coarse() && coarse == nullptr)
    return compute_by_picture(frames, outputs);

  if (kind == EngineKind::gpu) {
    try {
      return (*tables_->gpu)(frames, outputs, memory_->gpu, coarse);
    } catch (const GpuError& error) {  // the CPU gives the same result
      if (error.why == GpuFailure::lost) tables_->gpu->gpu->lose();
      tables_->fall_back(without_gpu(error.what()));
    }
  }

  // The CPU: the device's buffers, if a GPU was lost or given up, are not needed any more.
  memory_->gpu.slots.clear();
  (*tables_->fused)(frames, outputs, memory_->fused, coarse);
}

/// First finds coordinates with orders from the whole image, then computes the outputs from them.
/// Pixels without a coordinate get the reason, if it is known.
void Engine::compute_by_picture(const FrameViews& frames, const Outputs& outputs) {
  Memory& memory = *memory_;
  const DepthUnwrapper* const by_depth = tables_->reference().by_depth();

  // 1. Coordinates from surfaces, by the reference engine, or from the depth range: the fused pass
  //    gives the wrapped phase, which does not depend on the coordinates that it is given.
  if (by_depth == nullptr) {
    convert(tables_->reference().maps(frames).coordinate, memory.coarse);
  } else {
    if (memory.coarse.size() != frames.size()) memory.coarse = Image<float>(frames.size());
    compute(frames, {.maps = &memory.phases}, &memory.coarse);
    const Image<float>& phase = memory.phases.wrapped_phase;
    (*by_depth)(phase, memory.phases.modulation, frames.full_scale(), memory.orders);
    by_depth->unwrap(phase, memory.orders.order, memory.coarse);
  }

  // 2. The outputs from these coordinates.
  compute(frames, outputs, &memory.coarse);

  // 3. Why pixels have no coordinate; those too dark or saturated keep that reason.
  const auto set_reasons = [&](Image<Validity>& validity) {
    for_each_pixel(validity.size(), [&](int column, int row) {
      Validity& pixel = validity(column, row);
      const bool unmeasured = pixel == Validity::too_dark || pixel == Validity::saturated;
      if (unmeasured || !std::isnan(memory.coarse(column, row))) return;
      pixel = by_depth == nullptr ? Validity::doubtful_order : memory.orders.validity(column, row);
    });
  };

  if (outputs.cloud != nullptr) set_reasons(outputs.cloud->validity);
  if (outputs.depth != nullptr) set_reasons(outputs.depth->validity);
}

void Engine::reject_moved(const FrameViews& frames, const Outputs& outputs) {
  if (!tables_->measure_motion) return;
  FrameMotion& motion = memory_->motion;
  (*tables_->measure_motion)(frames, motion);

  // A residual beyond five standard deviations of the noise at full light is motion.
  constexpr double deviations = 5;
  const auto limit = static_cast<float>(deviations * std::sqrt(tables_->noise_variance_of(frames)));

  for_each_pixel(motion.unexplained.size(), [&](int column, int row) {
    if (!(motion.unexplained(column, row) > limit)) return;

    const auto reject = [&](Image<Validity>& validity, auto&... depths) {
      if (validity(column, row) != Validity::valid) return;
      validity(column, row) = Validity::moved;
      ((depths(column, row) = std::numeric_limits<float>::quiet_NaN()), ...);
    };

    if (Cloud* const cloud = outputs.cloud) {
      reject(cloud->validity, cloud->x, cloud->y, cloud->z);
    }
    if (Depth* const depth = outputs.depth) reject(depth->validity, depth->z);
    if (outputs.depth16 != nullptr) (*outputs.depth16)(column, row) = 0;
  });

  if (outputs.maps != nullptr) std::swap(outputs.maps->motion, motion.speed);
}

void Engine::reject_reflected(const FrameViews& frames, const Outputs& outputs) {
  const CleanSettings& clean = setup().settings.clean;
  if (!rejects_reflection(clean)) return;
  Cloud& cloud = *outputs.cloud;

  // 1. The errors that such light may cause, by the picture around and by the own surface.
  constexpr int half = 4, half_of_surface = 2;  // pixels
  const Disturbance disturbance = disturbance_of(frames, cloud, *outputs.maps, tables_->complete);
  const Image<float> local = predicted_errors(disturbance, cloud, half_of_surface, true);
  outputs.maps->reflection =
      clean.reflection > 0 ? predicted_errors(disturbance, cloud, half, false) : local;

  // 2. Reject those above a limit that is set.
  const auto exceeds = [](float error, double limit) { return limit > 0 && error > limit; };
  for_each_pixel(cloud.size(), [&](int column, int row) {
    if (exceeds(outputs.maps->reflection(column, row), clean.reflection) ||
        exceeds(local(column, row), clean.local_reflection)) {
      cloud.reject(column, row, Validity::reflected);
    }
  });
}

double Engine::moving_share(const FrameViews& frames) const {
  if (!tables_->measure_motion) return 0;
  const double grey_level = frames.full_scale() / 255;
  return tables_->measure_motion->moving_share(
      frames, tables_->complete.settings.minimum_modulation * grey_level,
      tables_->noise_variance_of(frames));
}

Uncertainty Engine::uncertainty(const Cloud& cloud, const Maps& maps, const FrameViews& captured) {
  tables_->require_geometry();
  return uncertainty_of(cloud, maps, tables_->complete, merged(captured).full_scale());
}

std::string Engine::backend_for(const FrameViews& frames) {
  if (setup().settings.custom_engine) return setup().settings.custom_engine->name;

  const EngineKind kind = tables_->engine_for(frames);
  if (kind == EngineKind::reference) {
    if (tables_->table_engine && TableEngine::takes(frames)) {
      return std::string(name_of(PhaseMethod::tables));
    }

    // Without the table engine, only the phases are looked up.
    const std::string method = tables_->reference().method_for(frames);
    const bool was_chosen = setup().settings.engine == EngineKind::reference;
    return was_chosen && method.find(name_of(PhaseMethod::tables)) != std::string::npos
               ? fmt::format("reference ({})", method)
               : method;
  }

  return kind == EngineKind::gpu ? "gpu" : "fused";
}

std::string Engine::fallback_reason() const {
  if (memory_->unquantised) return without_fused("it requires 8 to 16 bits");
  if (memory_->not_bytes) return without_tables("it requires 8 bits and a single exposure");
  return tables_->fell_back ? tables_->fallback_reason : "";
}

EngineSetup setup_for(const Scan& scan, const ReconstructSettings& settings) {
  if (!scan.scanner) throw Error("the scan has no scanner; add a calibration file");
  EngineSetup setup{
      completed(*scan.scanner, "the scanner", scan.frames.size(), scan.sequence.projector),
      scan.sequence, settings};
  require_ambient_known(setup, "the scanner");
  return setup;
}

}  // namespace slipstream
