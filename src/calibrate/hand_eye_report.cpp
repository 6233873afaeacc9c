#include "calibrate/hand_eye_report.h"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <fmt/ranges.h>

#include "base/numbers.h"
#include "calibrate/report.h"

namespace slipstream {
namespace {

std::string text_of(const HandEyeError& error) {
  return fmt::format("{:.3f} mm and {:.4f} degrees", error.translation, error.rotation / degree);
}

/// False for the mean of errors that were not measured.
bool is_known(const HandEyeError& error) {
  return std::isfinite(error.translation) && std::isfinite(error.rotation);
}

std::size_t used_count(const HandEye& found) {
  std::size_t used = 0;
  for (const HandEyePose& pose : found.each) used += pose.used ? 1 : 0;
  return used;
}

std::vector<std::string> cells_of(const std::optional<HandEyeError>& error) {
  if (!error) return {"-", "-"};
  return {fmt::format("{:.3f}", error->translation),
          fmt::format("{:.4f}", error->rotation / degree)};
}

void write_poses(Page& page, const HandEye& found) {
  page.heading("Poses");
  page.paragraph(
      "Distance and angle between each board as measured and as the robot's pose predicts it; held "
      "out: predicted by a calibration without this pose.");
  page.table({"pose", "mm", "degrees", "held out, mm", "held out, degrees", "used"});
  for (const HandEyePose& pose : found.each) {
    std::vector<std::string> cells{pose.name};
    for (const auto& error : {pose.error, pose.left_out}) {
      for (const std::string& cell : cells_of(error)) cells.push_back(cell);
    }
    cells.push_back(pose.used ? "yes" : pose.reason);
    page.row(cells);
  }
}

void write_scatter(Page& page, const HandEyeScatter& scatter) {
  page.heading("Whose errors");
  page.paragraph("Standard deviations of single poses that explain these errors best.");
  page.table({"", "mm", "degrees"});

  const auto row = [&](const char* what, double translation, double rotation) {
    page.row({what, fmt::format("{:.3f}", translation), fmt::format("{:.4f}", rotation / degree)});
  };
  row("robot, each axis", scatter.robot_translation, scatter.robot_rotation);
  row("board, across the line of sight and about it", scatter.board_across, scatter.board_roll);
  row("board, along the line of sight and tilt", scatter.board_depth, scatter.board_tilt);
}

/// Rows of a name and a value: conventions, poses and their standard deviations.
std::vector<std::vector<std::string>> rows_of(const HandEye& found) {
  const Eigen::Vector3d& at = found.poses.camera.translation();
  const Eigen::Vector3d& deviation = found.translation_deviation;

  std::vector<std::vector<std::string>> rows{
      {"robot poses", name_of(found.robot, robot_frames)},
      {"board poses", name_of(found.boards, board_frames)},
      {fmt::format("camera in the {}", carrier_of_camera(found.place)),
       fmt::format(
           "x {:.3f} +- {:.3f}, y {:.3f} +- {:.3f}, z {:.3f} +- {:.3f} mm, turned to within "
           "{:.4f} degrees",
           at.x(), deviation.x(), at.y(), deviation.y(), at.z(), deviation.z(),
           found.rotation_deviation.norm() / degree)},
      {fmt::format("errors of {} of {} poses", used_count(found), found.each.size()),
       text_of(found.mean)}};
  if (is_known(found.mean_left_out)) {
    rows.back().back() += "; held out " + text_of(found.mean_left_out);
  }
  return rows;
}

}  // namespace

std::string carrier_of_camera(EyePlace place) {
  return place == EyePlace::in_hand ? "tool" : "base";
}

std::string text_of(const HandEye& found) {
  std::vector<std::string> lines;
  for (const auto& row : rows_of(found)) lines.push_back(fmt::format("{}", fmt::join(row, ": ")));

  for (const MorePoses& more : found.more) {
    lines.push_back(fmt::format("with {}: position to within {:.3f} mm, now {:.3f} mm", more.which,
                                more.translation, found.translation_deviation.norm()));
  }
  return fmt::format("{}", fmt::join(lines, "\n"));
}

Page hand_eye_report(const HandEye& found, Wording wording) {
  Page page("Hand-eye calibration", wording);
  page.verdict(verdict_of(found.findings));

  if (!found.findings.empty()) {
    page.heading("Diagnostics");
    for (const Finding& finding : found.findings) page.paragraph("{}", text_of(finding));
  }

  page.heading("Result");
  page.table({"", "value"});
  for (const auto& row : rows_of(found)) page.row(row);
  page.row({"size of the boards by the robot's travel",
            fmt::format("{:.5f} +- {:.5f}", found.scale, found.scale_deviation)});
  page.paragraph(
      "The standard deviation is the larger of two: of the fit, and of calibrations that each "
      "leave out one pose. Small errors alone do not prove the result: verify it by touching a "
      "board.");

  page.heading("More poses");
  page.table({"with", "position, mm", "direction, degrees"});
  for (const MorePoses& more : found.more) {
    page.row({more.which, fmt::format("{:.3f}", more.translation),
              fmt::format("{:.4f}", more.rotation / degree)});
  }

  write_scatter(page, found.scatter);
  write_poses(page, found);
  return page;
}

}  // namespace slipstream
