// The fused pass gives the points of the reference engine, and leaves out the same pixels.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "bench/vector_target.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_scanner.h"
#include "tests/geometry/random_scanner.h"
#include "tests/reconstruct/agreement.h"

namespace slipstream::fused_cloud_test {

class FusedCloudOn : public testing::TestWithParam<std::string> {};

TEST_P(FusedCloudOn, HasThePointsOfTheEquations) {
  const OnlyVectorTarget only(GetParam());
  for (const int width : {160, 171}) {
    const Scanner scanner = example_scanner({width, 90});
    for (const Axis axis : {Axis::x, Axis::y}) {
      for (const Strategy& strategy :
           {Strategy(PhaseMeasuring{.steps = 3, .frequency = 1}),
            Strategy(PhaseMeasuring{.steps = 5, .frequency = 0.8}),
            Strategy(DualFrequency{.steps = 4, .low_steps = 3, .high = 16, .low = 1}),
            Strategy(DualFrequency{.steps = 6, .high = 8, .low = 0.5})}) {
        SCOPED_TRACE(testing::Message()
                     << strategy.name() << ", width " << width << ", axis " << name_of(axis));
        const Agreement agreement =
            agreement_on(setup_of(scanner, strategy, axis), statue_frames(scanner, strategy, axis));
        EXPECT_GT(agreement.points, 2000U);
        EXPECT_LE(agreement.other_validity, 1U);
        EXPECT_LE(agreement.worst, depth_bound);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(VectorTarget, FusedCloudOn, testing::ValuesIn(vector_targets()),
                         [](const auto& info) { return info.param; });

/// Pictures so large that most of their points come from RayBlocks, some of them not of whole
/// blocks.
TEST(FusedCloud, HasThePointsOfTheEquationsInLargePictures) {
  for (const int width : {640, 653}) {
    const Scanner scanner = example_scanner({width, 478});
    const Axis axis = width == 640 ? Axis::x : Axis::y;
    const Strategy strategy = width == 640 ? Strategy(PhaseMeasuring{.steps = 3, .frequency = 1})
                                           : Strategy(DualFrequency{.steps = 3});
    const FrameSet frames = statue_frames(scanner, strategy, axis);
    const EngineSetup setup = setup_of(scanner, strategy, axis);
    const ReferenceResult exact = by_equations(setup, frames);
    const auto fused = FusedEngine::make(setup, {});
    ASSERT_TRUE(fused);
    FusedMemory memory;
    for (const std::string& target : vector_targets()) {
      SCOPED_TRACE(testing::Message() << "width " << width << ", vectors " << target);
      const OnlyVectorTarget only(target);
      Cloud cloud;
      (*fused)(frames, {.cloud = &cloud}, memory);
      const Agreement agreement = compare(scanner, axis, cloud, exact);
      EXPECT_GT(agreement.points, 50000U);
      EXPECT_LE(agreement.other_validity, 3U);
      EXPECT_EQ(agreement.other_intensity, 0U);
      EXPECT_LE(agreement.worst, depth_bound);
    }
  }
}

TEST(FusedCloud, HasThePointsOfTheEquationsForAnyScanner) {
  int scanners = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Scanner scanner = random_scanner(seed, seed % 3 == 0 ? 0 : 0.08);
    // A picture of a quarter of the width and height: the same rays, fewer of them.
    scanner.camera.size = {160, 120};
    scanner.camera.intrinsic.topRows<2>() /= 4;
    const Strategy strategy = DualFrequency{.steps = 3, .high = 16, .low = 1};
    for (const Axis axis : {Axis::x, Axis::y}) {
      const EngineSetup setup = setup_of(scanner, strategy, axis);
      if (!FusedEngine::make(setup, {})) continue;
      SCOPED_TRACE(testing::Message() << "scanner " << seed << ", axis " << name_of(axis));
      const Scene board = scene_named("board", scanner);
      const FrameSet frames =
          take_scan(scanner, board, pattern_set(strategy, axis), {.bits = 12}).frames;
      const Agreement agreement = agreement_on(setup, frames);
      EXPECT_LE(agreement.other_validity, 2U);
      EXPECT_LE(agreement.worst, depth_bound);
      scanners += agreement.points > 1000 ? 1 : 0;
    }
  }
  EXPECT_GE(scanners, 12);
}

TEST(FusedCloud, LeavesOutTheSamePixelsForTheSameReasons) {
  const Scanner scanner = example_scanner({320, 240});
  const Strategy strategy = DualFrequency{};
  // Bright enough to saturate in places, dim enough in others to lose the fringe order.
  const FrameSet frames =
      statue_frames(scanner, strategy, Axis::x, {.ambient = 70, .noise_variance = 30});
  for (const ReconstructSettings& settings :
       {ReconstructSettings{}, ReconstructSettings{.minimum_modulation = 3},
        ReconstructSettings{.drop_saturated = false},
        ReconstructSettings{.minimum_modulation = 5,
        .fringe_order = {.largest_doubt = 0.1, .fewest_neighbours = 4, .fewest_if_doubtful = 8}},
        ReconstructSettings{.nearest = 560, .farthest = 600}}) {
    const Agreement agreement =
        agreement_on(setup_of(scanner, strategy, Axis::x, settings), frames);
    EXPECT_GT(agreement.points, 1000U);
    // Phases of few grey levels are fractions that meet a limit exactly, and rounding decides.
    EXPECT_LE(agreement.other_validity, 12U);
  }
}

TEST(FusedCloud, OfNoiseIsThatOfTheEquations) {
  const Scanner scanner = example_scanner({203, 151});
  for (const Strategy& strategy : {Strategy(PhaseMeasuring{.steps = 4, .frequency = 1}),
                                   Strategy(DualFrequency{.steps = 3})}) {
    std::mt19937 random(7);
    FrameSet::Images8 images;
    for (int n = 0; n < frame_count(strategy); ++n) {
      images.emplace_back(scanner.camera.size);
      for (std::uint8_t& pixel : images.back()) pixel = static_cast<std::uint8_t>(random());
    }
    const Agreement agreement =
        agreement_on(setup_of(scanner, strategy, Axis::x), FrameSet(images));
    EXPECT_GT(agreement.points, 500U);
    EXPECT_LE(agreement.other_validity, 30U);
    EXPECT_LE(agreement.worst, depth_bound);
  }
}

TEST(FusedCloud, IsTheSameOnAnyNumberOfThreads) {
  const Scanner scanner = example_scanner({320, 240});
  const Strategy strategy = DualFrequency{};
  const FrameSet frames = statue_frames(scanner, strategy, Axis::x);
  const auto reconstruct = FusedEngine::make(setup_of(scanner, strategy, Axis::x), {});
  FusedMemory memory;
  std::vector<Cloud> clouds(2);
  for (const std::size_t threads : {1U, 4U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    (*reconstruct)(frames, {.cloud = &clouds[threads == 1 ? 0 : 1]}, memory);
  }
  for (std::size_t i = 0; i < clouds[0].z.pixel_count(); ++i) {
    ASSERT_EQ(clouds[0].validity.begin()[i], clouds[1].validity.begin()[i]);
    ASSERT_EQ(clouds[0].intensity.begin()[i], clouds[1].intensity.begin()[i]);
    if (clouds[0].validity.begin()[i] != Validity::valid) continue;
    ASSERT_EQ(clouds[0].z.begin()[i], clouds[1].z.begin()[i]);
  }
}

TEST(FusedCloud, DepthAloneIsItsDepth) {
  const Scanner scanner = example_scanner({320, 240});
  const Strategy strategy = DualFrequency{};
  const FrameSet frames = statue_frames(scanner, strategy, Axis::x);
  const auto reconstruct = FusedEngine::make(setup_of(scanner, strategy, Axis::x), {});
  FusedMemory memory;
  Cloud cloud;
  Depth depth;
  (*reconstruct)(frames, {.cloud = &cloud}, memory);
  (*reconstruct)(frames, {.depth = &depth}, memory);
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    ASSERT_EQ(cloud.validity.begin()[i], depth.validity.begin()[i]);
    if (cloud.validity.begin()[i] == Validity::valid) {
      ASSERT_EQ(cloud.z.begin()[i], depth.z.begin()[i]);
    }
  }
}

TEST(FusedCloud, TheReferenceStandsInWhereItCannot) {
  const Sequence sequence{.strategy = PhaseMeasuring{.steps = 3, .frequency = 1}};
  const FrameSet bytes(FrameSet::Images8(3, Image<std::uint8_t>({64, 48})));
  const FrameSet unquantised(FrameSet::ImagesUnquantised(3, Image<double>({64, 48})));
  const FrameSet narrow(FrameSet::Images8(3, Image<std::uint8_t>({15, 48})));
  Scanner bent = example_scanner({64, 48});
  bent.projector.distortion = make_distortion(std::vector{-9.0, 0.0, 0.0, 0.0});
  for (const EngineKind kind : {EngineKind::fused, EngineKind::automatic}) {
    const ReconstructSettings settings{.engine = kind};
    Engine reconstruct(example_scanner({64, 48}), sequence, settings);
    EXPECT_EQ(reconstruct.backend_for(bytes), "fused");
    EXPECT_EQ(reconstruct.backend_for(unquantised), "equation");
    Cloud cloud;
    reconstruct.cloud(unquantised, cloud);
    EXPECT_EQ(point_count(cloud), 0U);

    EXPECT_EQ(reconstruct.fallback_reason(),
              "no fused engine: it requires 8 to 16 bits; using the reference engine");
    reconstruct.cloud(bytes, cloud);
    EXPECT_EQ(reconstruct.fallback_reason(), "");
    Engine of_narrow(example_scanner({15, 48}), sequence, settings);
    EXPECT_EQ(of_narrow.backend_for(narrow), "lut");
    EXPECT_EQ(of_narrow.fallback_reason(),
              "no fused engine: the image is narrower than 16 pixels; using the reference engine");
    Engine of_bent(bent, sequence, settings);
    EXPECT_EQ(of_bent.backend_for(bytes), "lut");
    EXPECT_EQ(of_bent.fallback_reason(),
              "no fused engine: the projector's lens model cannot be inverted over its picture; "
              "using the reference engine");
  }
  MicroPhaseShifting most;
  most.periods.clear();
  while (most.periods.size() < 64) most.periods.push_back(21 + 0.37 * std::ssize(most.periods));
  Engine of_most(example_scanner({64, 48}), {.strategy = most});
  EXPECT_EQ(of_most.backend_for(FrameSet(FrameSet::Images8(66, Image<std::uint8_t>({64, 48})))),
            "fused");

  // The tables' polynomials hold for 16 pixels along a row: a quarter of this picture, where a
  // projector's lens bends too much for them.
  const ReconstructSettings by_reference{.engine = EngineKind::reference};
  Engine reference(example_scanner({64, 48}), sequence, by_reference);
  EXPECT_EQ(reference.backend_for(bytes), "reference (lut)");
  EXPECT_EQ(reference.fallback_reason(),
            "no table engine: its polynomials do not describe this projector lens exactly enough; "
            "using the reference engine");

  Scanner straight = example_scanner({64, 48});
  straight.projector.distortion = {};
  Engine by_tables(straight, sequence, by_reference);
  EXPECT_EQ(by_tables.backend_for(bytes), "lut");
  EXPECT_EQ(by_tables.fallback_reason(), "");
}

TEST(FusedCloud, RefusesWhatDoesNotFit) {
  const Scanner scanner = example_scanner({64, 48});
  const ReconstructSettings fused{.engine = EngineKind::fused};
  EXPECT_THROW(
      Engine(setup_of(scanner, PhaseMeasuring{.steps = 3, .frequency = 8}, Axis::x, fused)), Error);
  ReconstructSettings negative = fused;
  negative.minimum_modulation = -1;
  EXPECT_THROW(Engine(setup_of(scanner, DualFrequency{}, Axis::x, negative)), Error);
  Scanner without_noise = scanner;
  without_noise.photometry.noise_variance = 0;
  EXPECT_THROW(Engine(setup_of(without_noise, PhaseChannelMultiplexing{}, Axis::x, fused)), Error);
  const auto reconstruct = FusedEngine::make(setup_of(scanner, DualFrequency{}, Axis::x), {});
  Cloud cloud;
  FusedMemory memory;
  for (const FrameSet& frames :
       {FrameSet(FrameSet::Images8(6, Image<std::uint8_t>({48, 48}))),
        FrameSet(FrameSet::Images8(5, Image<std::uint8_t>({64, 48}))),
        FrameSet(FrameSet::ImagesUnquantised(6, Image<double>({64, 48})))}) {
    EXPECT_THROW((*reconstruct)(frames, {.cloud = &cloud}, memory), Error);
  }
}

}  // namespace slipstream::fused_cloud_test
