#include "slipstream/performance/bench_rows.h"

#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "slipstream/gamma/correction.h"
#include "slipstream/performance/bench_scan.h"
#include "slipstream/performance/opencv_peers.h"
#include "slipstream/performance/published.h"
#include "slipstream/reconstruct/fused_reconstructor.h"

namespace slipstream {
namespace {

constexpr double cloud_bytes = 4 * sizeof(float) + 1;  ///< x, y, z, intensity, validity
/// The blocks' share in a pixel; those of the rows between two knots are the same.
constexpr double block_bytes =
    static_cast<double>(sizeof(RayBlocks::Block)) / (RayBlocks::width * RayBlocks::spacing);
constexpr double published_cloud_bytes = 4 * sizeof(double);

Frames<std::uint8_t> bytes_of(const FrameSet& frames) {
  return frames.visit([]<class Pixel>(const Frames<Pixel>& views) -> Frames<std::uint8_t> {
    if constexpr (sizeof(Pixel) == 1) return views;
    return {};
  });
}

BenchRow row_for(const BenchScan& scan, std::string name, int steps, double bytes,
                 std::function<void()> run) {
  const Size size = scan.scanner.camera.size;
  return {.name = std::move(name),
          .steps = steps,
          .width = size.width,
          .height = size.height,
          .bytes_per_pixel = bytes,
          .run = std::move(run)};
}

void add_published(std::vector<BenchRow>& rows, const std::shared_ptr<const BenchScan>& scan,
                   int steps) {
  const auto loops =
      std::make_shared<PublishedLoops>(scan->scanner, Axis::x, bytes_of(scan->frames));
  loops->general();  // the phase that the rows of points start from
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
  add("inverse", sizeof(PixelPosition) + 4 * number, &PublishedLoops::inverse);
  add("form1", sizeof(PointForm1) + 4 * number, &PublishedLoops::form1);
  add("form2", sizeof(PointForm2) + 4 * number, &PublishedLoops::form2);
  add("form3", sizeof(PointForm3) + 4 * number, &PublishedLoops::form3);
  add("traditional", N + sizeof(PixelPosition) + published_cloud_bytes,
      &PublishedLoops::traditional);
  add("lut", N + sizeof(PointForm3) + published_cloud_bytes, &PublishedLoops::lut);
}

/// The kernels of the fused pass, but each over the whole picture before the next, with images of
/// phase and flags between them.
class StageByStage {
 public:
  StageByStage(const BenchScan& scan, const Strategy& strategy)
      : frames_(bytes_of(scan.frames)),
        stages_(fused_stages(scan.scanner, strategy, Axis::x, {}).value()),
        limits_(sinusoid_limits(stages_.sinusoid, {}, 255, 1)),
        turn_(scan.scanner.camera.size),
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
      decode_row(stages_.sinusoid, limits_, frame_rows_.data(),
                 {.width = width,
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
  SinusoidLimits limits_;
  Image<float> turn_, mean_, x_, y_, z_;
  Image<std::int32_t> flags_;
  Image<Validity> validity_;
  std::vector<const std::uint8_t*> frame_rows_;
};

BenchRow fused_row(const std::shared_ptr<const BenchScan>& scan, const Strategy& strategy,
                   std::string name, int steps, const ReconstructSettings& settings = {}) {
  struct Work {
    FusedReconstructor reconstruct;
    Frames<std::uint8_t> frames;
    FusedCloud cloud;
  };
  const auto work = std::make_shared<Work>(
      Work{FusedReconstructor::make(scan->scanner, strategy, Axis::x, settings).value(),
           bytes_of(scan->frames),
           {}});
  const double bytes = frame_count(strategy) + block_bytes + cloud_bytes;
  return row_for(*scan, std::move(name), steps, bytes,
                 [scan, work] { work->reconstruct(work->frames, work->cloud); });
}

/// The rows of one N at 640x480.
void add_steps(std::vector<BenchRow>& rows, int steps,
               const std::shared_ptr<const BenchScan>& scan) {
  const Strategy strategy = PhaseMeasuring{.steps = steps, .frequency = 1};
  const Frames<std::uint8_t> frames = bytes_of(scan->frames);
  add_published(rows, scan, steps);
  const auto staged = std::make_shared<StageByStage>(*scan, strategy);
  const double between = 2 * (sizeof(float) + sizeof(std::int32_t));
  rows.push_back(row_for(*scan, "simd", steps, steps + between + block_bytes + cloud_bytes,
                         [scan, staged] { (*staged)(); }));
  rows.push_back(row_for(*scan, "tables", steps, 0, [scan, strategy] {
    static_cast<void>(fused_stages(scan->scanner, strategy, Axis::x, {}));
  }));
  rows.push_back(fused_row(scan, strategy, "fused", steps));
  ReconstructSettings corrected;
  corrected.phase_corrections = {{steps, phase_correction(PowerLaw{2.2}, steps)}};
  rows.push_back(fused_row(scan, strategy, "fused-corrected", steps, corrected));
  if (steps == 3) {
    if (auto psp = opencv_psp(frames)) {
      rows.push_back(row_for(*scan, "opencv-psp", steps, 0, [scan, psp] { psp(); }));
    }
  }
  rows.push_back(
      row_for(*scan, "opencv-hand", steps, 0,
              [scan, hand = opencv_by_hand(frames, scan->scanner, Axis::x)] { hand(); }));
}

void add_dual(std::vector<BenchRow>& rows, int steps) {
  const Strategy strategy =
      make_strategy("dual-frequency", {{"steps", steps}, {"high", 16}, {"low", 1}});
  const auto scan = std::make_shared<const BenchScan>(bench_scan(strategy));
  rows.push_back(fused_row(scan, strategy, "fused-dual", steps));
}

void add_multiplexed(std::vector<BenchRow>& rows, int steps) {
  const Strategy strategy = make_strategy("pcmp", {{"steps", steps}});
  ReconstructSettings settings;
  settings.cue.ambient = bench_ambient;
  const auto scan = std::make_shared<const BenchScan>(bench_scan(strategy));
  rows.push_back(fused_row(scan, strategy, "pcmp-" + std::to_string(steps), steps, settings));
}

}  // namespace

std::vector<BenchRow> bench_rows(const BenchSettings& settings) {
  std::vector<BenchRow> rows;
  const auto scan_of = [](int steps) {
    return std::make_shared<const BenchScan>(
        bench_scan(PhaseMeasuring{.steps = steps, .frequency = 1}));
  };
  const auto three_steps = scan_of(3);
  for (const int steps : settings.steps) {
    add_steps(rows, steps, steps == 3 ? three_steps : scan_of(steps));
  }
  for (const int steps : settings.steps) add_dual(rows, steps);
  for (const int steps : {3, 4, 5}) add_multiplexed(rows, steps);
  const Strategy three = PhaseMeasuring{.steps = 3, .frequency = 1};
  for (const int k : settings.enlargements) {
    const auto scan =
        k == 1 ? three_steps : std::make_shared<const BenchScan>(enlarged(*three_steps, k));
    BenchRow row = fused_row(scan, three, "fused", 3);
    if (k > 1) rows.push_back(row);
    if (settings.most_threads == 1) continue;
    row.threads = settings.most_threads;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace slipstream
