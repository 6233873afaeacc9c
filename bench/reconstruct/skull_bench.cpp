// A real scan taken by others, 1688x1352, six frames, from images in memory to cloud on one thread.
#include <cstdint>
#include <filesystem>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "slipstream/codes/phase_shifting.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/reconstruct/engine.h"
#include "tests/shared_data.h"

namespace slipstream {
namespace {

void skull_to_cloud(benchmark::State& state) {
  const std::filesystem::path folder = shared_data() / "skull";
  if (!std::filesystem::exists(folder)) return state.SkipWithError("the skull's data is not there");
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
