// A real scan taken by others, against a depth map computed independently of this project.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "slipstream/io/image_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/reconstruct/reconstructor.h"
#include "tests/shared_data.h"

namespace slipstream {
namespace {

class Skull : public testing::TestWithParam<Backend> {};

const Strategy strategy = DualFrequency{.steps = 3, .high = 16, .low = 1};

TEST_P(Skull, AgreesWithTheReferenceDepth) {
  const std::filesystem::path folder = shared_data() / "skull";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const Scanner scanner = read_scanner(folder / "calibration.xml");
  const LoadedFrames loaded = read_frames(images_in_folder(folder / "dual-frequency"));
  const Image<std::uint16_t> reference =
      read_grey_image(folder / "reference" / "dual-frequency-depth.png");

  const Reconstructor reconstruct(scanner, strategy, Axis::x,
                                  {.backend = GetParam(), .minimum_modulation = 15});
  EXPECT_EQ(reconstruct.backend_for(loaded.frames), name_of(GetParam()));
  const Cloud cloud = reconstruct(loaded.frames).cloud;

  int valid = 0, agreeing = 0, extra = 0;
  for (std::size_t i = 0; i < reference.pixel_count(); ++i) {
    const double z = cloud.z.begin()[i];
    if (reference.begin()[i] == 0) {
      extra += std::isfinite(z) ? 1 : 0;
      continue;
    }
    ++valid;
    if (std::abs(z - 0.01 * reference.begin()[i]) <= 0.02) ++agreeing;
  }
  EXPECT_EQ(valid, 340570);
  EXPECT_EQ(extra, 0);
  EXPECT_GE(agreeing, 0.995 * valid);
  RecordProperty("agreeing_percent", std::to_string(100.0 * agreeing / valid));
}

TEST(SkullFused, HasThePointsOfTheEquations) {
  const std::filesystem::path folder = shared_data() / "skull";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const Scanner scanner = read_scanner(folder / "calibration.xml");
  const FrameSet frames = read_frames(images_in_folder(folder / "dual-frequency")).frames;
  const auto cloud = [&](Backend backend) {
    return Reconstructor(scanner, strategy, Axis::x, {.backend = backend, .minimum_modulation = 15})
        .cloud(frames);
  };
  const Cloud exact = cloud(Backend::equation), fused = cloud(Backend::fused);
  int valid = 0, agreeing = 0, other_validity = 0;
  for (std::size_t i = 0; i < exact.z.pixel_count(); ++i) {
    const double z = exact.z.begin()[i];
    if (exact.validity.begin()[i] != fused.validity.begin()[i]) ++other_validity;
    if (!std::isfinite(z)) continue;
    ++valid;
    if (std::abs(fused.z.begin()[i] - z) <= 0.002) ++agreeing;
  }
  EXPECT_GT(valid, 300000);
  EXPECT_GE(agreeing, 0.999 * valid);
  EXPECT_LE(other_validity, 0.001 * valid);
}

INSTANTIATE_TEST_SUITE_P(Backend, Skull,
                         testing::Values(Backend::equation, Backend::closed_form, Backend::lut,
                                         Backend::fused),
                         [](const auto& info) {
                           std::string name(name_of(info.param));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace slipstream
