// Benchmarks of single stages.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "bench/bench_rows.h"
#include "bench/vector_target.h"
#include "geometry/ray_table.h"
#include "geometry/stripe_geometry.h"
#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "reconstruct/fused/fused_stages.h"
#include "reconstruct/fused/point_rows.h"
#include "reconstruct/fused/sinusoid_rows.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/scanner_file.h"
#include "tests/shared_data.h"

namespace slipstream {
namespace {

// Stages of the fused pass on a row of 640 pixels in cache, for every vector target.

constexpr int width = 640;
constexpr std::size_t row_size = width;

/// A row through the middle of the scene, and the outputs of the stages.
struct Row {
  explicit Row(const Strategy& strategy)
      : scan(bench_scan(strategy)),
        stages(fused_stages(setup_for(scan), {}).value()),
        limits(sinusoid_limits(stages.bands.front().sinusoid, {}, 255, 255, 1)) {
    scan.frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
      if constexpr (sizeof(Pixel) == 1) {
        for (const auto& view : views) frames.push_back(view.row(240));
      }
    });
  }

  void decode() {
    decode_row(stages.bands.front().sinusoid, frames.data(),
               {.limits = limits,
                .width = width,
                .turn = turn.data(),
                .mean = mean.data(),
                .flags = flags.data(),
                .nan_if_flagged = true});
  }

  Scan scan;
  FusedStages stages;
  SinusoidLimits limits;
  std::vector<const std::uint8_t*> frames;
  std::vector<float> turn = std::vector<float>(row_size), mean = turn, x = turn, y = turn, z = turn;
  std::vector<std::int32_t> flags = std::vector<std::int32_t>(row_size);
  std::vector<Validity> validity = std::vector<Validity>(row_size);
};

void count_pixels(benchmark::State& state) {
  state.SetItemsProcessed(state.iterations() * width);
}

void frames_to_turns(benchmark::State& state, const std::string& target, int steps) {
  const OnlyVectorTarget only(target);
  Row row(PhaseMeasuring{.steps = steps, .frequency = 1});
  for (auto _ : state) row.decode();
  count_pixels(state);
}

void turns_to_points(benchmark::State& state, const std::string& target) {
  const OnlyVectorTarget only(target);
  Row row(PhaseMeasuring{.steps = 3, .frequency = 1});
  row.decode();
  const PointRow points{.width = width,
                        .E_x = row.stages.rays.E_x.row(240),
                        .E_y = row.stages.rays.E_y.row(240),
                        .blocks = row.stages.blocks->at(240),
                        .flags = row.flags.data(),
                        .coordinate = row.turn.data(),
                        .x = row.x.data(),
                        .y = row.y.data(),
                        .z = row.z.data(),
                        .validity = row.validity.data()};
  for (auto _ : state) point_row(row.stages.point, row.stages.coordinate, points);
  count_pixels(state);
}

[[maybe_unused]] const bool registered = [] {
  for (const std::string& target : vector_targets()) {
    for (const int steps : {3, 4, 6, 5}) {
      benchmark::RegisterBenchmark(
          ("frames_to_turns/" + target + "/" + std::to_string(steps)).c_str(),
          [=](benchmark::State& state) { frames_to_turns(state, target, steps); });
    }
    benchmark::RegisterBenchmark(("turns_to_points/" + target).c_str(),
                                 [=](benchmark::State& state) { turns_to_points(state, target); });
  }
  return true;
}();

// Cost of a new scanner: the tables of the fused pass at 640x480.

void ray_table_640x480(benchmark::State& state) {
  const Lens camera = example_scanner().camera;
  for (auto _ : state) benchmark::DoNotOptimize(ray_table(camera));
}
BENCHMARK(ray_table_640x480)->Unit(benchmark::kMillisecond)->UseRealTime();

void stripe_geometry_with_projector_lens(benchmark::State& state) {
  const Scanner scanner = example_scanner();
  for (auto _ : state) benchmark::DoNotOptimize(stripe_geometry(scanner, Axis::x, 0.02));
}
BENCHMARK(stripe_geometry_with_projector_lens)->Unit(benchmark::kMillisecond);

// A real public scan, 1688x1352, six frames: images in memory to a cloud on one thread.
void skull_to_cloud(benchmark::State& state) {
  const std::filesystem::path folder = shared_data() / "skull";
  if (!std::filesystem::exists(folder))
    return state.SkipWithError("the data set 'skull' is missing");
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const Scanner scanner = read_scanner(folder / "calibration.xml");
  const FrameSet frames = read_frames(images_in_folder(folder / "dual-frequency")).frames;
  const DualFrequency strategy{.steps = 3, .low_steps = {}, .high = 16, .low = 1};
  Engine engine(scanner, {.strategy = strategy});
  const FrameViews views = frames;
  Cloud cloud;
  for (auto _ : state) engine.cloud(views, cloud);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(cloud.z.pixel_count()));
}
BENCHMARK(skull_to_cloud)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slipstream
