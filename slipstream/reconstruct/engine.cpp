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
#include "slipstream/decode/demodulator.h"
#include "slipstream/decode/frame_motion.h"
#include "slipstream/decode/temporal_unwrapping.h"
#include "slipstream/frames/merged_exposures.h"
#include "slipstream/reconstruct/detail/reference_engine.h"
#include "slipstream/reconstruct/fused/fused_engine.h"
#include "slipstream/reconstruct/gpu/gpu_engine.h"

namespace slipstream {
namespace {

bool is_point(Validity pixel) {
  return pixel == Validity::valid;
}
bool is_point(std::uint16_t number) {
  return number != 0;
}

void pack(const Cloud& cloud, PackedPoints& points) {
  const std::array values{std::pair(&cloud.x, &points.x), std::pair(&cloud.y, &points.y),
                          std::pair(&cloud.z, &points.z),
                          std::pair(&cloud.intensity, &points.intensity)};
  for (const auto& [from, to] : values) {
    if (to->size() != cloud.size()) *to = Image<float>(cloud.size(), uninitialised);
    points.count = 0;
    for (std::size_t i = 0; i < from->pixel_count(); ++i) {
      if (is_point(cloud.validity.begin()[i])) to->begin()[points.count++] = from->begin()[i];
    }
  }
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
  explicit Memory(const EngineSetup& setup) : clean(setup.settings.clean) {
    const auto& [scanner, sequence, settings] = setup;
    if (const auto how = sequence.strategy.demodulation()) demodulate.emplace(*how, sequence.axis);
  }

  FusedMemory fused;
  GpuScanMemory gpu;
  MergedFrames merged;
  std::optional<Demodulator> demodulate;
  Image<float> modulation;
  std::optional<Cloud> cloud;  ///< whose points are packed
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
  const auto& [scanner, sequence, settings] = setup();
  const std::vector<double>& exposures = sequence.exposures;
  if (memory_->demodulate && frames.count() != sequence.strategy.layout().frames) {
    return (*memory_->demodulate)(frames);
  }
  if (exposures.size() == 1 || frames.merged()) return frames;
  merge_exposures(frames, exposures, memory_->merged);
  return memory_->merged.views;
}

void Engine::raw_cloud(const FrameViews& frames, Cloud& cloud, Image<float>* modulation) {
  if (tables_->is_fused(frames)) {
    run_fused(frames, {.cloud = &cloud, .modulation = modulation});
  } else {
    const ReferenceResult result = tables_->reference()(frames);
    convert(result.cloud, cloud);
    if (modulation != nullptr) convert(result.maps.modulation, *modulation);
  }
  leave_out_moved(frames, cloud);
  divide_by_gain(frames, cloud.intensity);
}

ValidityCounts Engine::cloud(const FrameViews& given, Cloud& cloud) {
  tables_->require_geometry();
  const FrameViews& frames = merged(given);
  Image<float>& modulation = memory_->modulation;
  raw_cloud(frames, cloud, memory_->clean.wants_modulation() ? &modulation : nullptr);
  return memory_->clean(cloud, modulation, tables_->noise_for(frames));
}

void Engine::points(const FrameViews& given, PackedPoints& points) {
  tables_->require_geometry();
  const FrameViews& frames = merged(given);
  if (backend_for(frames) == "fused" && !frames.merged() && !tables_->measure_motion) {
    return run_fused(frames, {.points = &points});
  }
  if (!memory_->cloud) memory_->cloud.emplace();
  raw_cloud(frames, *memory_->cloud, nullptr);
  pack(*memory_->cloud, points);
}

void Engine::depth(const FrameViews& given, Depth& depth) {
  tables_->require_geometry();
  const FrameViews& frames = merged(given);
  if (tables_->is_fused(frames)) {
    run_fused(frames, {.depth = &depth});
  } else {
    const BasicCloud<double> cloud = tables_->reference()(frames).cloud;
    convert(cloud.z, depth.z);
    depth.validity = cloud.validity;
  }
  leave_out_moved(frames, depth.validity, [&](int column, int row) {
    depth.z(column, row) = std::numeric_limits<float>::quiet_NaN();
    depth.validity(column, row) = Validity::moved;
  });
}

void Engine::depth(const FrameViews& given, const DepthScale& scale,
                   Image<std::uint16_t>& numbers) {
  tables_->require_geometry();
  const FrameViews& frames = merged(given);
  if (tables_->is_fused(frames)) {
    run_fused(frames, {.numbers = &numbers, .scale = scale});
  } else {
    Image<float> z;
    convert(tables_->reference()(frames).cloud.z, z);
    if (numbers.size() != z.size()) numbers = Image<std::uint16_t>(z.size());
    std::transform(z.begin(), z.end(), numbers.begin(), scale);
  }
  leave_out_moved(frames, numbers, [&](int column, int row) { numbers(column, row) = 0; });
}

void Engine::maps(const FrameViews& given, Maps& maps) {
  const FrameViews& frames = merged(given);
  if (tables_->is_fused(frames)) {
    run_fused(frames, {.maps = &maps});
  } else {
    convert(tables_->reference().maps(frames), maps);
  }
  if (!tables_->measure_motion) return;
  (*tables_->measure_motion)(frames, memory_->motion);
  std::swap(maps.motion, memory_->motion.speed);
}

ValidityCounts Engine::cloud_and_maps(const FrameViews& given, Cloud& cloud, Maps& maps) {
  tables_->require_geometry();
  const FrameViews& frames = merged(given);
  if (tables_->is_fused(frames)) {
    run_fused(frames, {.cloud = &cloud, .maps = &maps});
  } else {
    const ReferenceResult result = tables_->reference()(frames);
    convert(result.cloud, cloud);
    convert(result.maps, maps);
  }
  leave_out_moved(frames, cloud);
  if (tables_->measure_motion) std::swap(maps.motion, memory_->motion.speed);
  divide_by_gain(frames, cloud.intensity);
  return memory_->clean(cloud, maps.modulation, tables_->noise_for(frames));
}

void Engine::run_pass(const FrameViews& frames, const FusedOutput& output,
                      const Image<float>* coarse) {
  if (tables_->gpu && !tables_->gpu_failed) {
    require_frames(frames, tables_->fused->stages());
    try {
      return (*tables_->gpu)(frames, output, memory_->gpu, coarse);
    } catch (const GpuError& error) {  // the same comes from the processor
      tables_->give_up_gpu(error);
    }
  }
  memory_->gpu.slots.clear();
  (*tables_->fused)(frames, output, memory_->fused, coarse);
}

/// The coordinates whose orders the picture gives, and why there is none, where that is known.
const Image<Validity>* Engine::find_coarse(const FrameViews& frames) {
  Memory& memory = *memory_;
  const DepthUnwrapper* const by_depth = tables_->reference().by_depth();
  if (by_depth == nullptr) {
    convert(tables_->reference().maps(frames).coordinate, memory.coarse);
    return nullptr;
  }
  if (memory.coarse.size() != frames.size()) memory.coarse = Image<float>(frames.size());
  run_pass(frames, {.maps = &memory.phases}, &memory.coarse);
  const Image<float>& phase = memory.phases.wrapped_phase;
  (*by_depth)(phase, memory.phases.modulation, frames.full_scale(), memory.orders);
  for_each_row(phase.height(), [&](int row) {
    const int* const order = memory.orders.order.row(row);
    for (int column = 0; column < phase.width(); ++column) {
      const double y = unwrapped_coordinate(phase(column, row), order[column], by_depth->periods());
      memory.coarse(column, row) = order[column] == SurfaceOrders::none
                                       ? std::numeric_limits<float>::quiet_NaN()
                                       : static_cast<float>(y);
    }
  });
  return &memory.orders.validity;
}

void Engine::run_fused(const FrameViews& frames, const FusedOutput& output) {
  if (!tables_->fused->wants_coarse()) return run_pass(frames, output, nullptr);
  const Image<Validity>* const order = find_coarse(frames);
  run_pass(frames, output, &memory_->coarse);
  const auto say_why = [&](Image<Validity>& validity) {
    for_each_row(validity.height(), [&](int row) {
      for (int column = 0; column < validity.width(); ++column) {
        Validity& pixel = validity(column, row);
        const bool unmeasured = pixel == Validity::too_dark || pixel == Validity::saturated;
        if (unmeasured || !std::isnan(memory_->coarse(column, row))) continue;
        pixel = order == nullptr ? Validity::doubtful_order : (*order)(column, row);
      }
    });
  };
  if (output.cloud != nullptr) say_why(output.cloud->validity);
  if (output.depth != nullptr) say_why(output.depth->validity);
}

template <class Pixel, class LeaveOut>
void Engine::leave_out_moved(const FrameViews& frames, const Image<Pixel>& pixels,
                             const LeaveOut& leave_out) {
  if (!tables_->measure_motion) return;
  FrameMotion& motion = memory_->motion;
  (*tables_->measure_motion)(frames, motion);
  constexpr double deviations = 5;
  const auto limit = static_cast<float>(deviations * std::sqrt(tables_->noise_variance_of(frames)));
  for_each_row(pixels.height(), [&](int row) {
    for (int column = 0; column < pixels.width(); ++column) {
      if (is_point(pixels(column, row)) && motion.unexplained(column, row) > limit)
        leave_out(column, row);
    }
  });
}

void Engine::leave_out_moved(const FrameViews& frames, Cloud& cloud) {
  leave_out_moved(frames, cloud.validity,
                  [&](int column, int row) { cloud.leave_out(column, row, Validity::moved); });
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
  return tables_->reference().uncertainty(cloud, maps, merged(given).full_scale());
}

std::string Engine::backend_for(const FrameViews& frames) {
  if (!tables_->is_fused(frames)) return tables_->reference().method_for(frames);
  return tables_->gpu && !tables_->gpu_failed ? "gpu" : "fused";
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
