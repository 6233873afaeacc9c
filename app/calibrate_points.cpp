#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/calibration_result.h"
#include "app/commands.h"
#include "base/numbers.h"
#include "calibrate/point_boards.h"
#include "io/point_lists.h"

namespace slipstream::app {
namespace {

/// The flags of `calibrate points`.
struct CalibratePointsFlags {
  std::string points;
  Size camera, projector;
  std::string unit = "auto";
  double first_pixel = 0;
  std::vector<std::string> swapped, excluded;
  CalibrationResultFlags result;
};

/// mm of a unit; nullopt for "auto".
std::optional<double> unit_named(const std::string& text) {
  if (text == "auto") return std::nullopt;
  if (text == "mm") return 1;
  if (text == "cm") return 10;
  if (text == "m") return 1000;
  if (text == "inch") return 25.4;

  const auto mm = number_in<double>(text);
  throw_if(!mm || !(*mm > 0),
           "--unit {} is unknown; expected auto, mm, cm, m, inch or a number of mm", text);
  return mm;
}

PointConventions conventions_from(const CalibratePointsFlags& flags) {
  PointConventions conventions{.unit = unit_named(flags.unit), .first_pixel = flags.first_pixel};
  for (const std::string& device : flags.swapped) {
    throw_if(device != "camera" && device != "projector",
             "--swap {} is unknown; expected camera or projector", device);
    (device == "camera" ? conventions.swaps_camera : conventions.swaps_projector) = true;
  }
  return conventions;
}

/// The poses without the excluded ones. Throws Error for a name that no pose has.
std::vector<PosePoints> without(std::vector<PosePoints> poses,
                                const std::vector<std::string>& excluded) {
  for (const std::string& name : excluded) {
    throw_if(std::erase_if(poses, [&](const PosePoints& pose) { return pose.name == name; }) == 0,
             "--exclude {}: there is no such pose", name);
  }
  return poses;
}

void calibrate_points(const CalibratePointsFlags& flags, Output& output) {
  const GeometryCalibrationSettings settings = settings_from(flags.result);
  const PointConventions conventions = conventions_from(flags);
  const std::optional<Scanner> other = compared_scanner(flags.result);

  // 1. Points of the other program, as boards.
  PointLists lists = read_point_lists(flags.points);
  output.say("{}", lists.layout);
  const PointBoards boards = boards_of_points(without(std::move(lists.poses), flags.excluded),
                                              flags.camera, flags.projector, conventions);
  for (const std::string& note : boards.notes) output.say("{}", with_flags(note));

  // 2. Calibrate as from frames.
  const GeometryCalibration calibration = calibrate_geometry(
      boards.views, boards.places, boards.spacing, flags.camera, flags.projector, settings);

  write_calibration(
      flags.result,
      {calibration,
       boards.places,
       fmt::format("board of {} points, {:.4g} mm apart", boards.places.size(), boards.spacing),
       boards.unused,
       {}},
      other, output);
  output.document["notes"] = boards.notes;
}

}  // namespace

void add_calibrate_points(const Commands& calibrate) {
  const auto [command, flags] = calibrate.add(
      calibrate_points, "points",
      "calibrate camera and projector from points of a board that another program found");
  required(
      command.add_file("points", flags.points,
                       "a table (.csv, .txt) with a row for each point: pose, board x y, camera "
                       "u v, projector u v; or a folder or .npz file with arrays of each"));
  add_result_flags(command, flags.result);
  required(command.add("--camera", flags.camera, "size of the camera's picture"));
  required(command.add("--projector", flags.projector, "size of the projector's picture"));
  command.add("--exclude", flags.excluded, "names of poses to ignore");

  const FlagGroup conventions{command.app, "Conventions"};
  conventions.add("--unit", flags.unit,
                  "of the board's points: mm, cm, m, inch or a number of mm; auto: m for boards of "
                  "less than 2, else mm");
  conventions.add("--first-pixel", flags.first_pixel,
                  "coordinate of the centre of the first pixel: 0, 0.5, or 1 as in MATLAB");
  conventions.add("--swap", flags.swapped,
                  "camera or projector, whose pixels are row, column; default: as the points show");

  add_model_flags({command.app, "Model"}, flags.result);
  command.common({"--output", "--report", "--camera", "--projector"});
  command.examples(
      {"calibrate points points.csv --camera 640x480 --projector 1280x800 -o "
       "scanner.yaml --report report"});
}

}  // namespace slipstream::app
