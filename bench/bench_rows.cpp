#include "bench/bench_rows.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "bench/opencv_peers.h"
#include "bench/vector_target.h"
#include "cloud/object_model.h"
#include "decode/equations.h"
#include "geometry/ray_blocks.h"
#include "io/file.h"
#include "live/window_engine.h"
#include "paper/published_loops.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/fused/fused_engine.h"
#include "reconstruct/fused/point_rows.h"
#include "reconstruct/fused/sinusoid_rows.h"
#include "reconstruct/gpu/gpu_engine.h"
#include "reconstruct/phase_matcher.h"
#include "response/correction.h"
#include "slipstream/engine.h"
#include "slipstream/gray_code.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {
namespace {

using SharedScan = std::shared_ptr<const Scan>;

constexpr double cloud_bytes = 4 * sizeof(float) + 1;  ///< x, y, z, intensity, validity
/// Bytes of blocks per pixel; rows between two knots share them.
constexpr double block_bytes =
    static_cast<double>(sizeof(RayBlocks::Block)) / (RayBlocks::width * RayBlocks::spacing);
constexpr double published_cloud_bytes = 4 * sizeof(double);

Frames<std::uint8_t> bytes_of(const FrameSet& frames) {
  return frames.visit([]<class Pixel>(const Frames<Pixel>& views) -> Frames<std::uint8_t> {
    if constexpr (sizeof(Pixel) == 1) return views;
    return {};
  });
}

BenchRow row_for(const Scan& scan, std::string name, int steps, double bytes,
                 std::function<void()> run) {
  const Size size = scan.frames.size();
  return {.name = std::move(name),
          .steps = steps,
          .width = size.width,
          .height = size.height,
          .bytes_per_pixel = bytes,
          .run = std::move(run)};
}

void add_published(std::vector<BenchRow>& rows, const SharedScan& scan, int steps) {
  const auto loops =
      std::make_shared<PublishedLoops>(*scan->scanner, Axis::x, bytes_of(scan->frames));
  loops->general();  // gives the rows of points their phase
  const auto add = [&](const char* name, double bytes, void (PublishedLoops::*loop)()) {
    rows.push_back(row_for(*scan, name, steps, bytes, [scan, loops, loop] { ((*loops).*loop)(); }));
  };
  constexpr double number = sizeof(double);
  const double N = steps;
  add("general", N + 2 * number, &PublishedLoops::general);
  add("closed-form", N + 2 * number, &PublishedLoops::closed_form);
  add("mlut", N + number, &PublishedLoops::mlut);
  add("plut", N + number, &PublishedLoops::plut);
  add("mlut+plut", N + 2 * number, &PublishedLoops::mlut_plut);
  if (steps == 3) add("2+1", N + 2 * number, &PublishedLoops::two_plus_one);
  add("inverse", sizeof(PixelPosition) + 4 * number, &PublishedLoops::inverse);
  add("form1", sizeof(PointForm1) + 4 * number, &PublishedLoops::form1);
  add("form2", sizeof(PointForm2) + 4 * number, &PublishedLoops::form2);
  add("form3", sizeof(PointForm3) + 4 * number, &PublishedLoops::form3);
  const double inverse_bytes = N + sizeof(PixelPosition) + published_cloud_bytes;
  add("equations", inverse_bytes, &PublishedLoops::equations);
  add("traditional", inverse_bytes, &PublishedLoops::traditional);
  add("lut", N + sizeof(PointForm3) + published_cloud_bytes, &PublishedLoops::lut);
}

/// The kernels of the fused pass, each over the whole image before the next, with intermediate
/// images of phase and flags.
class StageByStage {
 public:
  explicit StageByStage(const Scan& scan)
      : frames_(bytes_of(scan.frames)),
        stages_(fused_stages(setup_for(scan), {}).value()),
        sinusoid_(stages_.bands.front().sinusoid),
        limits_(sinusoid_limits(sinusoid_, {}, 255, 255, 1)),
        turn_(scan.frames.size()),
        mean_(turn_.size()),
        x_(turn_.size()),
        y_(turn_.size()),
        z_(turn_.size()),
        flags_(turn_.size()),
        validity_(turn_.size()),
        frame_rows_(frames_.size()) {}

  void operator()() {
    const int width = turn_.width();
    for (int row = 0; row < turn_.height(); ++row) {
      for (std::size_t n = 0; n < frames_.size(); ++n) frame_rows_[n] = frames_[n].row(row);
      decode_row(sinusoid_, frame_rows_.data(),
                 {.limits = limits_,
                  .width = width,
                  .turn = turn_.row(row),
                  .mean = mean_.row(row),
                  .flags = flags_.row(row),
                  .nan_if_flagged = true});
    }
    for (int row = 0; row < turn_.height(); ++row) {
      point_row(stages_.point, stages_.coordinate,
                {.width = width,
                 .E_x = stages_.rays.E_x.row(row),
                 .E_y = stages_.rays.E_y.row(row),
                 .blocks = stages_.blocks ? stages_.blocks->at(row) : RayBlocks::Row{},
                 .flags = flags_.row(row),
                 .coordinate = turn_.row(row),
                 .x = x_.row(row),
                 .y = y_.row(row),
                 .z = z_.row(row),
                 .validity = validity_.row(row)});
    }
  }

 private:
  Frames<std::uint8_t> frames_;
  FusedStages stages_;
  SinusoidStage sinusoid_;
  SinusoidLimits limits_;
  Image<float> turn_, mean_, x_, y_, z_;
  Image<std::int32_t> flags_;
  Image<Validity> validity_;
  std::vector<const std::uint8_t*> frame_rows_;
};

/// Result requested from a scan; `resident`: a cloud from frames on the device, which stays there.
/// The GPU gives no points.
enum class Asked { cloud, depth, depth16, resident, points };
constexpr std::array<const char*, 4> asked_names{"cloud", "depth", "depth16", "resident"};
constexpr std::array<double, 5> result_bytes{cloud_bytes, sizeof(float) + 1, sizeof(std::uint16_t),
                                             cloud_bytes, 4 * sizeof(float)};

/// Shared by rows of one size.
struct Results {
  Cloud cloud;
  Depth depth;
  Image<std::uint16_t> numbers;
  PackedPoints points;

  Outputs output(Asked asked) {
    if (asked == Asked::depth) return {.depth = &depth};
    if (asked == Asked::depth16) return {.depth16 = &numbers};
    if (asked == Asked::points) return {.points = &points};
    return {.cloud = &cloud};
  }
};

/// The fused pass alone.
BenchRow fused_row(const SharedScan& scan, std::string name, int steps,
                   Asked asked = Asked::cloud) {
  struct Work {
    FusedEngine engine;
    FrameViews frames;
    Results results;
    FusedMemory memory;
  };
  const EngineSetup setup = setup_for(*scan);
  const auto work =
      std::make_shared<Work>(Work{FusedEngine::make(setup, phase_corrections(setup)).value(),
                                  scan->frames, Results(), FusedMemory()});
  const double bytes =
      scan->frames.count() + block_bytes + result_bytes.at(static_cast<std::size_t>(asked));
  return row_for(*scan, std::move(name), steps, bytes, [scan, work, asked] {
    work->engine(work->frames, work->results.output(asked), work->memory);
  });
}

/// Cleaning, as Engine::cloud does after the fused pass. First restores the points that the last
/// cleaning removed, which is timed too.
class CleanAgain {
 public:
  explicit CleanAgain(const Scan& scan) {
    const EngineSetup setup = setup_for(scan, {.clean = CleanSettings::none()});
    noise_ = depth_noise(setup);
    Engine(setup).cloud_and_maps(scan.frames, cloud_, maps_);
    const Cloud raw = cloud_;
    clean_(cloud_, &maps_.modulation, noise_);
    for (std::size_t i = 0; i < raw.z.pixel_count(); ++i) {
      if (raw.validity.begin()[i] == cloud_.validity.begin()[i]) continue;
      taken_.push_back({i, raw.x.begin()[i], raw.y.begin()[i], raw.z.begin()[i]});
    }
  }

  void operator()() {
    for (const Taken& point : taken_) {
      cloud_.x.begin()[point.pixel] = point.x;
      cloud_.y.begin()[point.pixel] = point.y;
      cloud_.z.begin()[point.pixel] = point.z;
      cloud_.validity.begin()[point.pixel] = Validity::valid;
    }
    clean_(cloud_, &maps_.modulation, noise_);
  }

 private:
  struct Taken {
    std::size_t pixel;
    float x, y, z;
  };

  Cleaner clean_;
  DepthNoise noise_;
  Cloud cloud_;
  Maps maps_;
  std::vector<Taken> taken_;
};

/// The same through the public call.
BenchRow engine_row(const SharedScan& scan, std::string name, int steps,
                    const ReconstructSettings& settings = {}) {
  struct Work {
    Engine engine;
    FrameViews frames;
    Cloud cloud;
  };
  const auto work =
      std::make_shared<Work>(Work{Engine(setup_for(*scan, settings)), scan->frames, Cloud()});
  const double bytes = scan->frames.count() + block_bytes + cloud_bytes;
  return row_for(*scan, std::move(name), steps, bytes,
                 [scan, work] { work->engine.cloud(work->frames, work->cloud); });
}

/// Scans in one GPU submission: small ones, and as many of 640x480 as fit.
constexpr std::size_t many_small = 64, many = GpuEngine::pixels_at_once / (std::size_t{640} * 480);

/// A scan on the GPU, many times if requested, and in the fused pass. `results`: one per scan.
class OnBoth {
 public:
  OnBoth(const Scan& scan, std::shared_ptr<std::vector<Results>> results)
      : fused_(FusedEngine::make(setup_for(scan), phase_corrections(setup_for(scan))).value()),
        gpu_(GpuEngine::make(fused_, std::nullopt).value()),
        frames_(results->size(), scan.frames),
        results_(std::move(results)) {}

  void on_gpu(Asked asked) { on_gpu(asked, 1); }
  void many_on_gpu(Asked asked) { on_gpu(asked, results_->size()); }
  void fused(Asked asked) {
    fused_(frames_.front(), results_->front().output(asked), fused_memory_);
  }

 private:
  void on_gpu(Asked asked, std::size_t scans) {
    outputs_.clear();
    for (std::size_t i = 0; i < scans; ++i) outputs_.push_back((*results_)[i].output(asked));
    gpu_(std::span(frames_).first(scans), outputs_,
         asked == Asked::resident ? resident_ : gpu_memory_);
  }

  FusedEngine fused_;
  GpuEngine gpu_;
  std::vector<FrameViews> frames_;
  std::shared_ptr<std::vector<Results>> results_;
  std::vector<Outputs> outputs_;
  FusedMemory fused_memory_;
  GpuScanMemory gpu_memory_, resident_{.resident = true};
};

void add_gpu_rows(std::vector<BenchRow>& rows, const SharedScan& scan, const char* coding,
                  const std::shared_ptr<std::vector<Results>>& results, int threads) {
  const auto both = std::make_shared<OnBoth>(*scan, results);
  for (std::size_t i = 0; i < asked_names.size(); ++i) {
    const auto asked = static_cast<Asked>(i);
    const auto add = [&](const char* engine, void (OnBoth::*make)(Asked)) {
      rows.push_back(row_for(*scan, fmt::format("{}{}-{}", engine, coding, asked_names[i]), 3,
                             scan->frames.count() + result_bytes[i],
                             [scan, both, make, asked] { ((*both).*make)(asked); }));
      rows.back().threads = threads;
      rows.back().is_beside_gpu = true;
    };
    add("gpu", &OnBoth::on_gpu);
    if (results->size() > 1 && *coding == 0) {
      add("many-gpu", &OnBoth::many_on_gpu);
      rows.back().scans = static_cast<int>(results->size());
    }
    if (asked != Asked::resident) add("fused", &OnBoth::fused);
  }
}

/// Check of each cycle of frames in live.
BenchRow live_check_row(const SharedScan& scan, int steps) {
  const auto check =
      std::make_shared<LiveCheck>(scan->sequence, *scan->scanner, scan->frames.size());
  const FrameViews frames = scan->frames;
  check->look(frames);  // the first check covers the whole scan
  return row_for(*scan, "live-check", steps, 0,
                 [scan, check, frames] { static_cast<void>(check->look(frames)); });
}

/// Matching the frames of two cameras.
BenchRow pair_row(std::string name, int steps, const Strategy& strategy) {
  struct Work {
    explicit Work(const Strategy& strategy)
        : scan(bench_pair(strategy)),
          match(*scan.scanner, *scan.further_cameras.front().scanner, scan.sequence,
                {.nearest = 400, .farthest = 1000}) {}

    Scan scan;
    PhaseMatcher match;
    PhaseMatcher::Result result{};
  };
  const auto work = std::make_shared<Work>(strategy);
  BenchRow row = row_for(work->scan, std::move(name), steps, 0, [work] {
    work->match.run(work->scan.frames, work->scan.further_cameras.front().frames, work->result);
  });
  row.is_coding = true;
  return row;
}

/// Adds views of a statue, turned back and forth, to its model.
BenchRow model_view_row() {
  struct Work {
    std::array<Cloud, 2> views{statue_cloud(false), statue_cloud(true)};
    ObjectModel model{example_scanner().camera};
    std::size_t view = 0;
  };
  const auto work = std::make_shared<Work>();
  const Size size = work->views[0].size();
  return {
      .name = "model-view", .steps = 3, .width = size.width, .height = size.height, .run = [work] {
        const std::size_t view = work->view++;
        work->model.add(work->views[view % 2], static_cast<double>(view));
      }};
}

/// The scan, with a response to correct.
SharedScan with_gamma(const Scan& scan, double gamma) {
  Scan bent = scan;
  bent.scanner->photometry.response = {.response = PowerLaw{gamma}, .gamma = gamma};
  return std::make_shared<const Scan>(std::move(bent));
}

/// The scan, with lenses of a real scanner that no polynomial describes.
SharedScan with_bent_lenses(const Scan& scan) {
  Scan bent = scan;
  bent.scanner->camera.distortion = make_distortion(std::array{-0.0712, -0.185, 2e-4, 6e-4, 1.84});
  bent.scanner->projector.distortion =
      make_distortion(std::array{-0.0425, -0.66, -7e-4, 1.1e-3, 3.46});
  return std::make_shared<const Scan>(std::move(bent));
}

BenchRow tables_row(const SharedScan& scan, std::string name, int steps) {
  return row_for(*scan, std::move(name), steps, 0,
                 [scan, setup = setup_for(*scan)] { static_cast<void>(fused_stages(setup, {})); });
}

/// Adds the rows of one N at 640x480.
void add_steps(std::vector<BenchRow>& rows, int steps, const SharedScan& scan) {
  const Frames<std::uint8_t> frames = bytes_of(scan->frames);
  add_published(rows, scan, steps);
  const auto staged = std::make_shared<StageByStage>(*scan);
  const double between = 2 * (sizeof(float) + sizeof(std::int32_t));
  rows.push_back(row_for(*scan, "simd", steps, steps + between + block_bytes + cloud_bytes,
                         [scan, staged] { (*staged)(); }));
  rows.push_back(tables_row(scan, "tables", steps));
  const SharedScan bent = with_bent_lenses(*scan);
  rows.push_back(tables_row(bent, "tables-lens", steps));
  rows.push_back(fused_row(scan, "fused", steps));
  rows.push_back(fused_row(scan, "fused-depth", steps, Asked::depth));
  rows.push_back(fused_row(scan, "fused-depth16", steps, Asked::depth16));
  rows.push_back(fused_row(scan, "fused-points", steps, Asked::points));
  const auto clean = std::make_shared<CleanAgain>(*scan);
  rows.push_back(row_for(*scan, "clean", steps, 0, [clean] { (*clean)(); }));
  rows.push_back(engine_row(scan, "engine", steps));
  rows.push_back(engine_row(scan, "engine-raw", steps, {.clean = CleanSettings::none()}));
  rows.push_back(live_check_row(scan, steps));
  rows.push_back(fused_row(with_gamma(*scan, 2.2), "fused-corrected", steps));
  rows.push_back(fused_row(bent, "fused-lens", steps));
  if (steps == 3) {
    if (auto psp = opencv_psp(frames)) {
      rows.push_back(row_for(*scan, "opencv-psp", steps, 0, [scan, psp] { psp(); }));
    }
    rows.push_back(model_view_row());
  }
  rows.push_back(
      row_for(*scan, "opencv-hand", steps, 0,
              [scan, hand = opencv_by_hand(frames, *scan->scanner, Axis::x)] { hand(); }));
}

SharedScan scan_of(const Strategy& strategy) {
  return std::make_shared<const Scan>(bench_scan(strategy));
}

SharedScan scan_of(int steps) {
  return scan_of(PhaseMeasuring{.steps = steps, .frequency = 1});
}

}  // namespace

std::vector<BenchRow> gpu_rows(const BenchSettings& settings) {
  std::vector<BenchRow> rows;
  for (const Size size : settings.small) {
    const PhaseMeasuring coding{.steps = 3, .frequency = 1};
    add_gpu_rows(rows, std::make_shared<const Scan>(bench_scan(coding, size)), "",
                 std::make_shared<std::vector<Results>>(many_small), settings.most_threads);
  }
  const std::array<std::pair<const char*, SharedScan>, 3> scans{
      {{"", scan_of(3)},
       {"-dual", scan_of(DualFrequency{})},
       {"-multi", scan_of(MultiFrequency{})}}};
  for (const int k : std::set{settings.enlargements.front(), settings.enlargements.back()}) {
    const auto results = std::make_shared<std::vector<Results>>(k == 1 ? many : 1);
    for (const auto& [coding, scan] : scans) {
      const SharedScan large = k == 1 ? scan : std::make_shared<const Scan>(enlarged(*scan, k));
      add_gpu_rows(rows, large, coding, results, settings.most_threads);
    }
  }
  return rows;
}

std::vector<BenchRow> bench_rows(const BenchSettings& settings) {
  std::vector<BenchRow> rows;
  const SharedScan three_steps = scan_of(3);
  for (const int steps : settings.steps) {
    add_steps(rows, steps, steps == 3 ? three_steps : scan_of(steps));
  }
  for (const int steps : settings.steps) {
    const DualFrequency dual{.steps = steps, .low_steps = {}, .high = 16, .low = 1};
    rows.push_back(fused_row(scan_of(dual), "fused-dual", steps));
  }
  const auto add_coding = [&](const char* name, int steps, const Strategy& strategy) {
    rows.push_back(fused_row(scan_of(strategy), name, steps));
    rows.back().is_coding = true;
  };
  add_coding("multi-frequency", 3, MultiFrequency{});
  add_coding("gray-phase", 4, GrayPhase{});
  for (const int steps : {3, 4, 5}) {
    const std::string name = fmt::format("pcmp-{}", steps);
    add_coding(name.c_str(), steps, make_strategy("pcmp", {{"steps", steps}}));
  }
  add_coding("pcps-4", 4, PeriodCoded{});

  // Motion is measured outside the pass.
  const auto add_motion = [&](const char* name, const Strategy& strategy) {
    const int steps = strategy.layout().frames;
    rows.push_back(
        engine_row(scan_of(strategy.in_motion(2)), name, steps, {.clean = CleanSettings::none()}));
    rows.back().is_coding = true;
  };
  add_motion("motion-2", PhaseMeasuring{4, 1});
  add_motion("pcmp-5-motion-2", PhaseChannelMultiplexing{.steps = 5});
  rows.push_back(pair_row("two-cameras", 3, DualFrequency{}));
  rows.push_back(pair_row("two-cameras-one-band", 4, PhaseMeasuring{4, 16}));
  for (const std::string& target : vector_targets()) {
    if (target == vector_targets().front()) continue;
    BenchRow row = fused_row(three_steps, "fused-" + target, 3);
    row.is_coding = true;
    row.run = [target, fused = row.run] {
      const OnlyVectorTarget only(target);
      fused();
    };
    rows.push_back(std::move(row));
  }
  for (const int k : settings.enlargements) {
    const SharedScan scan =
        k == 1 ? three_steps : std::make_shared<const Scan>(enlarged(*three_steps, k));
    BenchRow row = fused_row(scan, "fused", 3);
    if (k > 1) rows.push_back(row);
    if (settings.most_threads == 1) continue;
    row.threads = settings.most_threads;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace slipstream
