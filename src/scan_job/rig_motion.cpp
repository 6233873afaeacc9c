#include "scan_job/rig_motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <string>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "base/linear_algebra.h"

namespace slipstream {
namespace {

/// The size of a change of the rig: up to three numbers, in degrees, mm, per cent or pixels.
using Amounts = Eigen::Vector3d;

/// A change of the rig since its calibration.
struct RigMotion {
  CauseKind kind = CauseKind::rig_moved;
  int unknowns = 0;  ///< of the amounts, from the first
  std::function<void(Scanner& scanner, const Amounts& amounts)> apply;
  std::function<std::string(const Amounts& amounts)> text;
};

Eigen::Matrix3d rotation_by(const Amounts& degrees) {
  const Eigen::Vector3d turn = degrees * std::numbers::pi / 180;
  if (turn.norm() == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
}

void zoom(Lens& lens, double per_cent) {
  lens.intrinsic(0, 0) *= 1 + per_cent / 100;
  lens.intrinsic(1, 1) *= 1 + per_cent / 100;
}

std::vector<RigMotion> possible_motions() {
  const auto text = [](const char* what, const char* unit) {
    return [what, unit](const Amounts& amounts) {
      return fmt::format("{} by {:.2g} {}", what, amounts.norm(), unit);
    };
  };

  return {
      // A device that turned about its own centre.
      {.unknowns = 3,
       .apply = [](Scanner& scanner, const Amounts& by) { scanner.rotation *= rotation_by(by); },
       .text = text("the camera turned", "degrees")},
      {.unknowns = 3,
       .apply =
           [](Scanner& scanner, const Amounts& by) {
             scanner.rotation = (rotation_by(by) * scanner.rotation).eval();
             scanner.translation = (rotation_by(by) * scanner.translation).eval();
           },
       .text = text("the projector turned", "degrees")},

      // Either moved without a turn.
      {.unknowns = 3,
       .apply = [](Scanner& scanner, const Amounts& by) { scanner.translation += by; },
       .text = text("the camera or the projector moved", "mm or more")},

      // A lens was turned.
      {.unknowns = 1,
       .apply = [](Scanner& scanner, const Amounts& by) { zoom(scanner.camera, by.x()); },
       .text = text("the camera's focal length changed", "%")},
      {.unknowns = 1,
       .apply = [](Scanner& scanner, const Amounts& by) { zoom(scanner.projector, by.x()); },
       .text = text("the projector's focal length changed", "%")},

      // A cropped or padded picture.
      {.kind = CauseKind::picture_size,
       .unknowns = 2,
       .apply =
           [](Scanner& scanner, const Amounts& by) {
             scanner.camera.intrinsic.topRightCorner<2, 1>() += by.head<2>();
           },
       .text =
           [](const Amounts& by) {
             return fmt::format(
                 "pictures cropped or padded since, by {:+.0f} columns and {:+.0f} rows", by.x(),
                 by.y());
           }},
  };
}

/// The distances of the pixels from their epipolar lines, projector pixels.
Eigen::VectorXd distances(const Scanner& scanner, const std::vector<SeenPixel>& pixels) {
  constexpr double beyond_the_lens = 1e3;

  Eigen::VectorXd distances(static_cast<Eigen::Index>(pixels.size()));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto& [camera, x, y] = pixels[i];
    const double distance =
        epipolar_distance(scanner, ray_through(scanner.camera, camera), x, y).distance;
    distances[static_cast<Eigen::Index>(i)] = std::isfinite(distance) ? distance : beyond_the_lens;
  }
  return distances;
}

double mean_square(const Eigen::VectorXd& values) {
  return values.squaredNorm() / static_cast<double>(values.size());
}

Scanner moved(Scanner scanner, const RigMotion& motion, const Amounts& amounts) {
  motion.apply(scanner, amounts);
  return scanner;
}

/// The amounts that bring the pixels nearest to their lines: Gauss and Newton's method. A
/// move along the baseline, which the lines do not show, remains 0.
Amounts fitted_amounts(const RigMotion& motion, const Scanner& scanner,
                       const std::vector<SeenPixel>& pixels) {
  constexpr int rounds = 8;
  constexpr double step = 1e-3;

  Amounts amounts = Amounts::Zero();
  for (int round = 0; round < rounds; ++round) {
    // 1. The distances, and how they change with each amount.
    const Eigen::VectorXd now = distances(moved(scanner, motion, amounts), pixels);
    Eigen::MatrixXd slopes(now.size(), motion.unknowns);
    for (int i = 0; i < motion.unknowns; ++i) {
      const Amounts next = amounts + step * Amounts::Unit(i);
      slopes.col(i) = (distances(moved(scanner, motion, next), pixels) - now) / step;
    }

    // 2. The change of the amounts that makes them least.
    Eigen::MatrixXd normal = slopes.transpose() * slopes;
    normal.diagonal().array() += 1e-6 * normal.trace() + 1e-12;
    amounts.head(motion.unknowns) -= solve_symmetric(normal, slopes.transpose() * now);
  }
  return amounts;
}

/// A cause, and the mean square of the distances that it leaves.
struct Explained {
  double left = 0;
  Cause cause;
};

/// Pictures saved another way round.
void add_turned_pictures(const Scanner& scanner, const std::vector<SeenPixel>& pixels,
                         std::vector<Explained>& list) {
  const Size size = scanner.camera.size;
  const auto add = [&](bool columns, bool rows, const char* how) {
    std::vector<SeenPixel> turned = pixels;
    for (SeenPixel& pixel : turned) {
      if (columns) pixel.camera.x() = size.width - 1 - pixel.camera.x();
      if (rows) pixel.camera.y() = size.height - 1 - pixel.camera.y();
    }
    list.push_back(
        {mean_square(distances(scanner, turned)),
         {CauseKind::picture_orientation, fmt::format("pictures {} since the calibration", how)}});
  };

  add(true, true, "turned upside down");
  add(true, false, "mirrored left to right");
  add(false, true, "mirrored top to bottom");
}

}  // namespace

std::vector<Cause> rig_motions(const Scanner& scanner, const GuardCheck& guard) {
  constexpr std::size_t fewest = 100, most = 3;
  const std::vector<SeenPixel>& pixels = guard.pixels;
  if (pixels.size() < fewest) return {};

  // 1. Each possible change, and the distances that it leaves.
  std::vector<Explained> list;
  for (const RigMotion& motion : possible_motions()) {
    const Amounts amounts = fitted_amounts(motion, scanner, pixels);
    const double left = mean_square(distances(moved(scanner, motion, amounts), pixels));

    // Cropped by hundreds of pixels, a picture also passes for one under a longer lens.
    const bool is_absurd =
        motion.kind == CauseKind::picture_size && 4 * amounts.norm() > scanner.camera.size.width;
    if (!is_absurd) list.push_back({left, {motion.kind, motion.text(amounts)}});
  }
  add_turned_pictures(scanner, pixels, list);
  std::ranges::stable_sort(list, {}, &Explained::left);

  // 2. The best one must explain most of the distances, and leave little more than noise.
  const double before = mean_square(distances(scanner, pixels)), best = list.front().left;
  const double sigma = std::min(guard.epipolar.median_sigma, 1.4826 * guard.epipolar.own);
  const double most_left = std::max(0.5, 3 * sigma);
  const double explained = before - best, explainable = before - sigma * sigma;
  if (best > most_left * most_left || explained < 0.7 * explainable) return {};

  // 3. Others that explain nearly as much are as likely.
  const double limit = std::min(1.5 * best, best + 0.1 * explained);
  std::vector<Cause> causes;
  for (Explained& each : list) {
    if (each.left <= limit && causes.size() < most) causes.push_back(std::move(each.cause));
  }
  return causes;
}

}  // namespace slipstream
