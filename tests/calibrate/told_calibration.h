// Diagnostics of calibrations from virtual frames, correct or corrupted.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "slipstream/board_capture.h"
#include "slipstream/error.h"
#include "slipstream/geometry_calibration.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {

using Pictures = std::vector<Image<std::uint8_t>>;

/// Diagnostics of a calibration, and the error that ended it, if any.
struct Told {
  std::vector<Finding> findings{};
  std::string error{};
};

inline std::string text_of(const Told& told) {
  std::string text = told.error.empty() ? "" : "error: " + told.error + "\n";
  for (const Finding& finding : told.findings) text += text_of(finding) + "\n";
  return text;
}

/// Whether a diagnostic's likely cause, or the error, contains `cause`.
inline bool names(const Told& told, const std::string& cause) {
  const auto has = [&](const std::string& text) { return text.find(cause) != std::string::npos; };
  return has(told.error) ||
         std::any_of(told.findings.begin(), told.findings.end(),
                     [&](const Finding& found) { return has(causes_of(found)); });
}

/// A simulated board calibration, and the settings passed to it.
struct BoardScene {
  CalibrationBoard board{.columns = 9, .rows = 6, .spacing = 20};
  Strategy strategy = DualFrequency{.steps = 3, .high = 8, .low = 1};
  Photometry photometry{.ambient = 5, .noise_variance = 1.55, .bits = 8};
  Size camera{320, 240};
  int poses = 6;
  std::optional<CalibrationBoard> said_board{};  ///< default: `board`
  std::optional<Strategy> said_strategy{};
  std::optional<MeasuredResponse> response{};  ///< if known
  /// Corrupts the pictures of a pose along an axis.
  std::function<void(Pictures& pictures, int pose, Axis axis)> spoil{};
};

inline Pictures pictures_of(const FrameViews& frames) {
  Pictures pictures;
  frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      Image<std::uint8_t> picture(frames.size());
      for (int row = 0; row < picture.height(); ++row) {
        for (int column = 0; column < picture.width(); ++column) {
          picture(column, row) = static_cast<std::uint8_t>(view(column, row));
        }
      }
      pictures.push_back(std::move(picture));
    }
  });
  return pictures;
}

/// Simulates one pose along one axis. Rays are traced once per board and pose.
inline Scan board_scan(const BoardScene& scene, const Scanner& scanner, const Body& sheet, int pose,
                       Axis axis) {
  using Key = std::tuple<BoardKind, int, double, int, int, Axis>;
  static std::map<Key, VirtualScan> traced;
  const Sequence shown{
      .strategy = scene.strategy, .axis = axis, .projector = scanner.projector.size};
  const Key key{
      scene.board.kind, scene.board.columns, scene.board.spacing, scene.camera.width, pose, axis};
  if (!traced.contains(key)) traced.emplace(key, take_scan(scanner, {sheet}, pattern_set(shown)));
  Photometry photometry = scene.photometry;
  photometry.seed = static_cast<std::uint64_t>(2 * pose + (axis == Axis::x ? 1 : 2));
  Pictures pictures = pictures_of(take_again(traced.at(key), pattern_set(shown), photometry));
  if (scene.spoil) scene.spoil(pictures, pose, axis);
  Sequence said = shown;
  if (scene.said_strategy) said.strategy = *scene.said_strategy;
  return {.frames = FrameSet(std::move(pictures)), .sequence = said};
}

/// Calibrates from frames as the program does, and collects diagnostics.
inline Told told_of(const BoardScene& scene) {
  const Scanner scanner = example_scanner(scene.camera);
  const CalibrationBoard said = scene.said_board.value_or(scene.board);
  constexpr int pixels_per_spacing = 50;
  Body sheet = printed_sheet(draw_board(scene.board, pixels_per_spacing),
                             scene.board.spacing / pixels_per_spacing, scanner);
  const auto& [width, height] = std::get<Board>(sheet.shape);
  Told told;
  std::vector<BoardView> views;
  std::string why_not;
  try {
    int pose = 0;
    for (const Eigen::Isometry3d& place : board_poses(scanner, scene.poses, width, height)) {
      sheet.pose = place;
      BoardCapture capture = board_capture(
          "pose" + std::to_string(pose), said, board_scan(scene, scanner, sheet, pose, Axis::x),
          board_scan(scene, scanner, sheet, pose, Axis::y), {.response = scene.response});
      ++pose;
      if (capture.view) views.push_back(*capture.view);
      if (!capture.view) why_not = capture.message;
      told.findings.insert(told.findings.end(), capture.findings.begin(), capture.findings.end());
    }
    if (views.size() < fewest_poses) throw Error(why_not);
    const GeometryCalibration calibration =
        calibrate_geometry(views, said, scanner.camera.size, scanner.projector.size,
                           {.camera_coefficients = 2, .projector_coefficients = 2});
    told.findings.insert(told.findings.end(), calibration.findings.begin(),
                         calibration.findings.end());
  } catch (const Error& error) {
    told.error = error.what();
  }
  return told;
}

/// Blurs the pictures by a Gaussian of `sigma` pixels, like a defocused lens.
inline void blur(Pictures& pictures, double sigma) {
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  for (Image<std::uint8_t>& picture : pictures) {
    Image<double> from(picture.size());
    std::copy(picture.begin(), picture.end(), from.begin());
    for (const bool across : {true, false}) {
      Image<double> to(picture.size());
      for (int row = 0; row < to.height(); ++row) {
        for (int column = 0; column < to.width(); ++column) {
          double sum = 0, weights = 0;
          for (int k = -reach; k <= reach; ++k) {
            const int x = std::clamp(across ? column + k : column, 0, to.width() - 1);
            const int y = std::clamp(across ? row : row + k, 0, to.height() - 1);
            const double weight = std::exp(-k * k / (2 * sigma * sigma));
            sum += weight * from(x, y);
            weights += weight;
          }
          to(column, row) = sum / weights;
        }
      }
      from = std::move(to);
    }
    std::transform(from.begin(), from.end(), picture.begin(),
                   [](double grey) { return static_cast<std::uint8_t>(std::lround(grey)); });
  }
}

}  // namespace slipstream
