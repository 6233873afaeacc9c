// Live clouds of every kind of sequence: user-defined strategies, exposure brackets, motion
// compensation.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "frames/pattern_windows.h"
#include "slipstream/engine.h"
#include "slipstream/frame_set.h"
#include "slipstream/live_pipeline.h"
#include "tests/live/scripted_source.h"
#include "tests/live/virtual_loop.h"
#include "tests/own_strategies.h"

namespace slipstream::live_sequences_test {

/// Counts of live clouds from a virtual camera: all, equal to an offline reconstruction, with
/// points.
struct Made {
  std::size_t clouds = 0, same = 0, with_points = 0;
  std::uint64_t resynchronisations = 0;
};

Made made_live(const Strategy& strategy, std::uint64_t frames, std::size_t begin = 0) {
  std::vector<Frame> loop = frames_of(strategy, {.motion = {0.2, 0, 0}, .cycles = 4});
  std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(begin), loop.end());
  const EngineSetup setup{example_scanner({64, 48}), {.strategy = strategy}, {}};
  Engine alone(setup);
  Made made;
  LivePipeline pipeline(
      std::make_unique<VirtualCamera>(loop), setup,
      {.indexing = PatternIndexing::counted,
       .most_frames = frames,
       .on_cloud = [&](const Pooled<LiveCloud>& live) {
         Cloud expected;
         alone.cloud(views_of(live->frames), expected);
         const std::size_t bytes = expected.z.pixel_count() * sizeof(float);
         ++made.clouds;
         made.with_points += point_count(live->cloud) > 500 ? 1 : 0;
         made.same += std::memcmp(live->cloud.z.begin(), expected.z.begin(), bytes) == 0 ? 1 : 0;
       }});
  run_to_its_end(pipeline);
  EXPECT_EQ(pipeline.failure(), nullptr);
  made.resynchronisations = pipeline.statistics().resynchronisations;
  return made;
}

TEST(LiveSequences, LivePipelineEachFrameGivesACloudOfAStrategyOfOnesOwn) {
  for (const Strategy& strategy : own_strategies()) {
    SCOPED_TRACE(strategy.name());
    const auto N = static_cast<std::size_t>(frame_count(strategy));
    const Made made = made_live(strategy, 10 * N);
    EXPECT_EQ(made.clouds, 9 * N + 1);
    EXPECT_EQ(made.same, made.clouds);
    EXPECT_EQ(made.with_points, made.clouds);
    EXPECT_EQ(made.resynchronisations, 0U);
  }
}

TEST(LiveSequences, ExposuresLiveCloudsAreThoseOfAFolder) {
  const Scanner scanner = example_scanner({96, 72});
  const Sequence sequence{.strategy = DualFrequency{}, .exposures = {0.5, 2, 8}};
  const auto loop = virtual_frames(scanner, scene_named("contrast", scanner), pattern_set(sequence),
                                   {.ambient = 5, .noise_variance = 1}, 1);
  Engine of_folder(scanner, merged_sequence(sequence));
  int equal = 0, other = 0;
  LiveSettings settings{.most_frames = 60};
  settings.on_cloud = [&](const Pooled<LiveCloud>& live) {
    const FrameSet merged = merged_exposures(views_of(live->frames), sequence.exposures);
    Cloud cloud;
    of_folder.cloud(merged, cloud);
    const bool same =
        std::equal(cloud.intensity.begin(), cloud.intensity.end(), live->cloud.intensity.begin()) &&
        std::memcmp(cloud.z.begin(), live->cloud.z.begin(),
                    cloud.z.pixel_count() * sizeof(float)) == 0;
    ++(same && point_count(cloud) > 0 ? equal : other);
  };
  LivePipeline pipeline(std::make_unique<VirtualCamera>(loop), {scanner, sequence}, settings);
  run_to_its_end(pipeline);
  EXPECT_EQ(pipeline.failure(), nullptr);
  EXPECT_EQ(equal, 60 - static_cast<int>(loop.size()) + 1);
  EXPECT_EQ(other, 0);
}

/// Largest difference in depth, mm; infinite if only one cloud has a point there.
double largest_difference(const Cloud& a, const Cloud& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.z.pixel_count(); ++i) {
    const double z = a.z.begin()[i], other = b.z.begin()[i];
    if (std::isnan(z) && std::isnan(other)) continue;
    const double apart = std::abs(z - other);
    largest = std::isnan(apart) ? INFINITY : std::max(largest, apart);
  }
  return largest;
}

TEST(LiveSequences, LiveMotionGivesACloudForEachFrameWhereverItsWindowBegins) {
  constexpr std::uint64_t frames = 40;
  for (const int steps : {3, 4}) {
    const Strategy cycle = PhaseMeasuring{
        .steps = steps, .frequency = 1, .shifts = {.origin = 2.1, .backwards = steps == 3}};
    EngineSetup setup{example_scanner({64, 48}),
                      {.strategy = cycle, .motion = 2},
                      {.clean = CleanSettings::none()}};
    // No motion and almost no noise: every window gives the same cloud as a cycle.
    const std::vector<Frame> loop = frames_of(
        cycle, {.cycles = 2, .photometry = {.ambient = 5, .noise_variance = 1e-3, .bits = 12}});
    Cloud still;
    std::vector<Image<std::uint16_t>> one;
    for (int n = 0; n < steps; ++n) {
      one.push_back(std::get<Image<std::uint16_t>>(loop[static_cast<std::size_t>(n)].pixels));
    }
    Engine(setup.scanner, {.strategy = cycle}, setup.settings).cloud(FrameSet(one, 12), still);

    std::vector<int> begun(static_cast<std::size_t>(steps));
    double largest = 0;
    LivePipeline pipeline(std::make_unique<VirtualCamera>(loop), setup,
                          {.indexing = PatternIndexing::counted,
                           .most_frames = frames,
                           .on_cloud = [&](const Pooled<LiveCloud>& live) {
                             ++begun[static_cast<std::size_t>(live->first_pattern)];
                             largest = std::max(largest, largest_difference(live->cloud, still));
                           }});
    run_to_its_end(pipeline);
    EXPECT_EQ(pipeline.failure(), nullptr);
    EXPECT_EQ(pipeline.statistics().clouds, frames - static_cast<std::uint64_t>(steps) - 1);
    for (const int count : begun) EXPECT_GE(count, 8);
    // With the wrong first pattern the error would be hundreds of mm.
    EXPECT_LT(largest, 3) << steps << " steps";
    EXPECT_EQ(pipeline.newest()->first_pattern, 0);
    for (const LiveFinding& told : pipeline.findings()) ADD_FAILURE() << told.finding.what;
  }
}

}  // namespace slipstream::live_sequences_test
