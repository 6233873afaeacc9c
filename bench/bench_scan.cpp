#include <cstdint>
#include <numbers>
#include <utility>

#include "bench/bench_rows.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"

namespace slipstream {
namespace {

Image<std::uint8_t> enlarged(const ImageView<const std::uint8_t>& image, int k) {
  Image<std::uint8_t> large({image.width() * k, image.height() * k});
  for (int row = 0; row < large.height(); ++row) {
    for (int column = 0; column < large.width(); ++column) {
      large(column, row) = image(column / k, row / k);
    }
  }
  return large;
}

}  // namespace

Scan bench_scan(const Strategy& strategy, Size camera) {
  constexpr double ambient = 5;
  Scan scan{.sequence = {.strategy = strategy}, .scanner = example_scanner(camera)};
  scan.scanner->photometry.ambient = ambient;
  scan.sequence.projector = scan.scanner->projector.size;
  const Scene statue = scene_named("statue", *scan.scanner);
  scan.frames = take_scan(*scan.scanner, statue, pattern_set(scan.sequence),
                          {.ambient = ambient, .noise_variance = 1.55, .bits = 8})
                    .frames;
  return scan;
}

Scan bench_pair(const Strategy& strategy) {
  Scan pair = bench_scan(strategy);
  const Scanner& first = *pair.scanner;
  Scan second{.sequence = pair.sequence, .scanner = second_scanner(first)};
  second.frames = take_scan(*second.scanner,
                            seen_from_second(scene_named("statue", first), first, *second.scanner),
                            pattern_set(second.sequence),
                            {.ambient = 5, .noise_variance = 1.55, .bits = 8, .seed = 2})
                      .frames;
  pair.further_cameras.push_back(std::move(second));
  return pair;
}

Scan enlarged(const Scan& scan, int k) {
  const Size size = scan.frames.size();
  Scan large = scan;
  large.scanner = example_scanner({size.width * k, size.height * k});
  large.scanner->photometry = scan.scanner->photometry;
  FrameSet::Images8 frames;
  scan.frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (sizeof(Pixel) == 1) {
      for (const auto& view : views) frames.push_back(enlarged(view, k));
    }
  });
  large.frames = FrameSet(std::move(frames));
  return large;
}

Cloud statue_cloud(bool turned) {
  const Scanner scanner = example_scanner();
  Scene scene = scene_named("statue", scanner);
  std::erase_if(scene, [](const Body& body) { return body.fixed; });
  const Motion turntable{.turn = {0, std::numbers::pi / 180, 0},
                         .centre = working_volume(scanner).centre};
  if (turned) {
    scene.front().pose = Eigen::Isometry3d(turntable.at(1).matrix()) * scene.front().pose;
  }
  const Sequence sequence{.strategy = DualFrequency{.steps = 3, .high = 16, .low = 1}};
  Cloud cloud;
  Engine(scanner, sequence)
      .cloud(take_scan(scanner, scene, pattern_set(sequence), {.noise_variance = 1.55}).frames,
             cloud);
  return cloud;
}

}  // namespace slipstream
