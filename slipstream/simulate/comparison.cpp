#include "slipstream/simulate/comparison.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <variant>

#include "slipstream/reconstruct/engine.h"

namespace slipstream {
namespace {

/// The world with a share of the light for each frame, and as much more gain.
VirtualWorld with_exposure(VirtualWorld world, double share) {
  world.photometry.noise_variance /= share;
  world.photometry.physics.full_well *= share;
  for (Body& body : world.scene) body.motion.pace *= share;
  return world;
}

double milliseconds_of(Engine& engine, const FrameSet& frames, Cloud cloud) {
  constexpr int times = 5;
  using Clock = std::chrono::steady_clock;
  double fastest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < times; ++i) {
    const Clock::time_point start = Clock::now();
    engine.cloud(frames, cloud);
    const std::chrono::duration<double, std::milli> taken = Clock::now() - start;
    fastest = std::min(fastest, taken.count());
  }
  return fastest;
}

/// The world's scanner with all that calibrations would find.
Scanner fully_calibrated(const VirtualWorld& world) {
  Scanner scanner = as_calibrated(world);
  const Response& response = world.photometry.response;
  if (is_linear(response)) return scanner;
  const auto* const law = std::get_if<PowerLaw>(&response);
  scanner.photometry.response.emplace(
      MeasuredResponse{.response = response, .gamma = law != nullptr ? law->gamma : 1});
  return scanner;
}

ComparedSequence judged(const VirtualWorld& world, const Sequence& sequence,
                        const ReconstructSettings& settings) {
  const PatternSet patterns = pattern_set(sequence);
  Engine engine(fully_calibrated(world), sequence, settings);
  const VirtualScan scan = take_scan(world.scanner, world.scene, patterns, world.photometry);
  ComparedSequence result;
  Maps maps;
  engine.cloud_and_maps(scan.frames, result.cloud, maps);
  const Uncertainty sigma = engine.uncertainty(result.cloud, maps, scan.frames);
  result.errors = cloud_errors(result.cloud, sigma, maps.coordinate, sequence.strategy.layout(),
                               scan, world.scanner, world.scene);
  result.decode_ms = milliseconds_of(engine, scan.frames, result.cloud);
  if (!is_moving(world.scene)) {
    Photometry again = world.photometry;
    ++again.seed;
    Cloud second;
    engine.cloud(take_again(scan, patterns, again), second);
    result.repeatability = repeatability(result.cloud, second);
  }
  return result;
}

}  // namespace

std::vector<ComparedSequence> compare(const VirtualWorld& world,
                                      const std::vector<Sequence>& sequences,
                                      const ReconstructSettings& settings) {
  int fewest = std::numeric_limits<int>::max();
  for (const Sequence& sequence : sequences) fewest = std::min(fewest, frame_count(sequence));
  std::vector<ComparedSequence> all;
  for (const Sequence& sequence : sequences) {
    const double share = static_cast<double>(fewest) / frame_count(sequence);
    all.push_back(judged(with_exposure(world, share), sequence, settings));
  }
  return all;
}

}  // namespace slipstream
