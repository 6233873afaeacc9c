// Calibration errors of random rigs must match their estimated standard deviations.
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "slipstream/board_capture.h"
#include "slipstream/geometry_calibration.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream::random_rigs_test {

class Chance {
 public:
  explicit Chance(unsigned seed) : random_(seed) {}
  double about(double middle, double spread) {
    return std::uniform_real_distribution<double>(middle - spread, middle + spread)(random_);
  }

 private:
  std::mt19937 random_;
};

Lens random_lens(Size size, double usual_focal, Chance& chance) {
  const double focal = usual_focal * chance.about(1, 0.15);
  Lens lens{.size = size};
  lens.intrinsic << focal, 0, size.width * chance.about(0.5, 0.02), 0,
      focal * chance.about(1, 0.003), size.height * chance.about(0.5, 0.02), 0, 0, 1;
  lens.distortion = make_distortion(std::array{chance.about(-0.08, 0.12), chance.about(0.03, 0.06),
                                               chance.about(0, 6e-4), chance.about(0, 6e-4), 0.0});
  return lens;
}

/// A camera beside, above or below a projector, both aimed at a point about 600 mm away.
Scanner random_rig(Size camera, Chance& chance) {
  Scanner rig;
  rig.camera = random_lens(camera, 1.3 * camera.width, chance);
  rig.projector = random_lens({1280, 800}, 1500, chance);
  const double side = chance.about(0, 1) < 0 ? -1 : 1;
  const Eigen::Vector3d centre(side * chance.about(150, 50), chance.about(0, 100),
                               chance.about(0, 20));
  const Eigen::Vector3d target(chance.about(0, 15), chance.about(0, 15), chance.about(600, 40));
  const Eigen::Vector3d forward = (target - centre).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(forward).normalized();
  rig.rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  rig.rotation = Eigen::AngleAxisd(chance.about(0, 0.05), Eigen::Vector3d::UnitZ()) * rig.rotation;
  rig.translation = -rig.rotation * centre;
  return rig;
}

/// Calibrates from simulated frames, with the program's defaults.
GeometryCalibration calibrated(const Scanner& rig, int count, std::uint64_t seed) {
  const CalibrationBoard board{
      .columns = 13, .rows = 9, .spacing = std::floor(working_volume(rig).extent / 19)};
  constexpr int pixels_per_spacing = 50;
  Body sheet =
      printed_sheet(draw_board(board, pixels_per_spacing), board.spacing / pixels_per_spacing, rig);
  const auto& [width, height] = std::get<Board>(sheet.shape);
  std::vector<BoardView> views;
  for (const Eigen::Isometry3d& pose : board_poses(rig, count, width, height)) {
    sheet.pose = pose;
    const auto scan = [&](Axis axis) {
      const Sequence shown{.strategy = DualFrequency{.steps = 4, .high = 16, .low = 1},
                           .axis = axis,
                           .projector = rig.projector.size};
      const Photometry photometry{.ambient = 5, .noise_variance = 1.55, .bits = 8, .seed = ++seed};
      return Scan{.frames = take_scan(rig, {sheet}, pattern_set(shown), photometry).frames,
                  .sequence = shown};
    };
    const BoardCapture capture = board_capture("pose", board, scan(Axis::x), scan(Axis::y));
    EXPECT_TRUE(capture.view) << capture.message;
    if (capture.view) views.push_back(*capture.view);
  }
  return calibrate_geometry(views, board, rig.camera.size, rig.projector.size);
}

/// Errors of one kind of parameter.
struct Errors {
  double squares = 0, squares_in_deviations = 0;
  int count = 0, beyond_two = 0;

  void add(double error, double deviation) {
    if (deviation == 0) return;  // fixed parameter
    squares += error * error;
    squares_in_deviations += std::pow(error / deviation, 2);
    beyond_two += std::abs(error) > 2 * deviation ? 1 : 0;
    ++count;
  }
  [[nodiscard]] double rms() const { return std::sqrt(squares / count); }
  [[nodiscard]] double rms_in_deviations() const {
    return std::sqrt(squares_in_deviations / count);
  }
};

struct AllErrors {
  Errors focal, centres, distortion, rotation, translation, all;

  void add(Errors& kind, double error, double deviation) {
    kind.add(error, deviation);
    all.add(error, deviation);
  }
  void add(const Lens& lens, const Lens& truth, const LensDeviation& deviation) {
    const Eigen::Matrix3d off = lens.intrinsic - truth.intrinsic;
    const double focal_length = truth.intrinsic(0, 0);
    add(focal, off(0, 0) / focal_length, deviation.focal.x() / focal_length);
    add(focal, off(1, 1) / focal_length, deviation.focal.y() / focal_length);
    add(centres, off(0, 2), deviation.principal_point.x());
    add(centres, off(1, 2), deviation.principal_point.y());
    for (std::size_t i = 0; i < deviation.coefficients.size(); ++i) {
      add(distortion, lens.distortion.coefficients[i] - truth.distortion.coefficients[i],
          deviation.coefficients[i]);
    }
  }
  void add(const GeometryCalibration& found, const Scanner& truth) {
    const Scanner& scanner = found.state.scanner;
    add(scanner.camera, truth.camera, found.deviation.camera);
    add(scanner.projector, truth.projector, found.deviation.projector);
    const Eigen::AngleAxisd is(scanner.rotation), ought(truth.rotation);
    const Eigen::Vector3d turn = is.angle() * is.axis() - ought.angle() * ought.axis();
    for (int i = 0; i < 3; ++i) {
      add(rotation, turn[i], found.deviation.rotation[i]);
      add(translation, scanner.translation[i] - truth.translation[i],
          found.deviation.translation[i]);
    }
  }
};

// SLIPSTREAM_RIGS=30 runs 30 rigs, with a larger camera and more poses, for the figures in
// docs/how-to/calibrate.md.
TEST(RandomRigs, AreOffByAsMuchAsTheirStandardDeviationsSay) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "too slow under the sanitizers";
#endif
  const char* const asked = std::getenv("SLIPSTREAM_RIGS");
  const int rigs = asked != nullptr ? std::atoi(asked) : 4;
  const Size camera = asked != nullptr ? Size{640, 480} : Size{320, 240};
  const int poses = asked != nullptr ? 12 : 8;
  AllErrors errors;
  for (int i = 1; i <= rigs; ++i) {
    Chance chance(static_cast<unsigned>(i));
    const Scanner rig = random_rig(camera, chance);
    errors.add(calibrated(rig, poses, 1000 * static_cast<std::uint64_t>(i)), rig);
  }
  const auto tell = [](const char* kind, const Errors& of_kind, double unit, const char* name) {
    fmt::print("{}: RMS error {:.4f} {}; in standard deviations {:.2f}, {:.1f} % beyond 2\n", kind,
               of_kind.rms() / unit, name, of_kind.rms_in_deviations(),
               100.0 * of_kind.beyond_two / of_kind.count);
  };
  constexpr double degree = std::numbers::pi / 180;
  tell("focal lengths", errors.focal, 0.01, "%");
  tell("principal points", errors.centres, 1, "px");
  tell("distortion", errors.distortion, 1, "");
  tell("rotation", errors.rotation, degree, "degrees");
  tell("translation", errors.translation, 1, "mm");
  tell("all", errors.all, 1, "in their units");
  const bool many = rigs >= 30;
  EXPECT_GT(errors.all.rms_in_deviations(), many ? 0.8 : 0.4);
  EXPECT_LT(errors.all.rms_in_deviations(), many ? 1.25 : 1.6);
}

}  // namespace slipstream::random_rigs_test
