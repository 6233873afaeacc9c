// Live pipeline: after each new frame, a callback gets a cloud of the newest four.
#include <atomic>
#include <cstdio>
#include <memory>

#include "slipstream/live_pipeline.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

using namespace slipstream;

int main() {
  const Scanner scanner = example_scanner({320, 240});
  const Sequence sequence{.strategy = make_strategy("pmp", {{"steps", 4}})};
  auto camera = std::make_unique<VirtualCamera>(
      virtual_frames(scanner, scene_named("statue", scanner), pattern_set(sequence),
                     {.ambient = 5, .noise_variance = 1.55, .bits = 8}, 4),
      200.0);  // frames per second

  std::atomic<std::size_t> points = 0;
  LiveSettings settings;
  settings.most_frames = 100;
  settings.on_cloud = [&](const Pooled<LiveCloud>& cloud) { points = point_count(cloud->cloud); };

  LivePipeline pipeline(std::move(camera), {scanner, sequence}, settings);
  pipeline.start();
  pipeline.wait();
  pipeline.stop();
  const LiveStatistics statistics = pipeline.statistics();
  std::printf("%llu clouds, the last of %zu points, half of them within %.1f ms of capture\n",
              static_cast<unsigned long long>(statistics.clouds), points.load(),
              statistics.latency.p50);
}
