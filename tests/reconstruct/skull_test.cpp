// A real scan taken by others, against a depth map computed independently of this project.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "decode/equations.h"
#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "slipstream/engine.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"
#include "tests/io/grey_image.h"
#include "tests/shared_data.h"

namespace slipstream::skull_test {

/// How it is computed, and as what backend_for names it.
struct Way {
  ReconstructSettings settings;
  std::string name;
};

constexpr double least = 15;
const Way equation{{.engine = EngineKind::reference,
                    .phase_method = PhaseMethod::equation,
                    .minimum_modulation = least,
                    .clean = CleanSettings::none()},
                   "equation"};
const Way closed_forms{{.engine = EngineKind::reference,
                        .phase_method = PhaseMethod::closed_form,
                        .minimum_modulation = least,
                        .clean = CleanSettings::none()},
                       "closed-form"};
const Way tables{{.engine = EngineKind::reference,
                  .phase_method = PhaseMethod::tables,
                  .minimum_modulation = least,
                  .clean = CleanSettings::none()},
                 "lut"};
const Way fused{
    {.engine = EngineKind::fused, .minimum_modulation = least, .clean = CleanSettings::none()},
    "fused"};

class Skull : public testing::TestWithParam<Way> {};

const Sequence sequence{.strategy = DualFrequency{.steps = 3, .high = 16, .low = 1}};

TEST_P(Skull, AgreesWithTheReferenceDepth) {
  const std::filesystem::path folder = shared_data() / "skull";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const Scanner scanner = read_scanner(folder / "calibration.xml");
  const LoadedFrames loaded = read_frames(images_in_folder(folder / "dual-frequency"));
  const Image<std::uint16_t> reference =
      read_grey_image(folder / "reference" / "dual-frequency-depth.png");

  Engine engine(scanner, sequence, GetParam().settings);
  EXPECT_NE(engine.backend_for(loaded.frames).find(GetParam().name), std::string::npos);
  Cloud cloud;
  engine.cloud(loaded.frames, cloud);

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
  const auto cloud_by = [&](const Way& way) {
    Cloud cloud;
    Engine(scanner, sequence, way.settings).cloud(frames, cloud);
    return cloud;
  };
  const Cloud exact = cloud_by(equation), quick = cloud_by(fused);
  int valid = 0, agreeing = 0, other_validity = 0;
  for (std::size_t i = 0; i < exact.z.pixel_count(); ++i) {
    const double z = exact.z.begin()[i];
    if (exact.validity.begin()[i] != quick.validity.begin()[i]) ++other_validity;
    if (!std::isfinite(z)) continue;
    ++valid;
    if (std::abs(quick.z.begin()[i] - z) <= 0.002) ++agreeing;
  }
  EXPECT_GT(valid, 300000);
  EXPECT_GE(agreeing, 0.999 * valid);
  EXPECT_LE(other_validity, 0.001 * valid);
}

INSTANTIATE_TEST_SUITE_P(Way, Skull, testing::Values(equation, closed_forms, tables, fused),
                         [](const auto& info) {
                           std::string name = info.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace slipstream::skull_test
