#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/calibrate_boards.h"
#include "app/commands.h"
#include "app/hand_eye.h"
#include "app/scan_flags.h"
#include "base/numbers.h"
#include "calibrate/hand_eye_report.h"
#include "calibrate/hand_eye_start.h"
#include "calibrate/touch_test.h"
#include "cloud/stitching.h"
#include "io/image_file.h"
#include "io/pose_file.h"
#include "io/pose_table_file.h"
#include "slipstream/cloud_file.h"
#include "slipstream/scanner_file.h"

namespace slipstream::app {
namespace {

/// The hand-eye pose of a file.
struct ReadHandEye {
  EyePlace place;
  Eigen::Isometry3d camera;  ///< to tool or base
};

ReadHandEye read_hand_eye(const std::string& file) {
  const FramePose pose = pose_from_frame(read_pose(file), camera_frame);
  throw_if(
      pose.to != "tool" && pose.to != "base",
      "{} leads from the camera to {}; expected the pose of calibrate hand-eye, to tool or base",
      file, pose.to);
  return {pose.to == "tool" ? EyePlace::in_hand : EyePlace::to_hand, pose.transform};
}

struct RobotPoseFlags {
  std::string columns, robot_convention;
};

void add_robot_pose_flags(const FlagGroup& command, RobotPoseFlags& flags) {
  required(command.add("--robot-convention", flags.robot_convention,
                       "convention of the robot's poses, as `calibrate hand-eye` prints it"));
  command.add("--table-columns", flags.columns, columns_help);
}

/// The poses, tool to base, of a file whose convention is known.
std::vector<Eigen::Isometry3d> read_robot_poses(const std::string& file,
                                                const RobotPoseFlags& flags) {
  const PoseTable table = read_pose_table(file, flags.columns);
  const auto conventions =
      conventions_of(table.rows.front().size(), robot_frames, flags.robot_convention);
  throw_if(conventions.size() != 1,
           "--robot-convention '{}' leaves several readings, for example '{}' and '{}'; give all "
           "parts, as calibrate hand-eye prints them",
           flags.robot_convention, name_of(conventions.front(), robot_frames),
           name_of(conventions.back(), robot_frames));

  std::vector<Eigen::Isometry3d> poses;
  for (const auto& pose : poses_of(table, conventions.front())) {
    throw_if(!pose, "{}: pose {} is none in this convention", file, poses.size() + 1);
    poses.push_back(*pose);
  }
  return poses;
}

/// A tip on points, and where the camera was when it saw them.
struct TipFlags {
  std::string hand_eye, touched, tip;
  std::optional<std::string> view;
  RobotPoseFlags robot;
  double tolerance = 0.5;
};

struct TouchFlags {
  TipFlags robot;
  std::string points;
};

struct ProjectionFlags {
  TipFlags robot;
  BoardCaptureFlags boards;
  std::string scanner, rings;
};

/// Camera to base.
Eigen::Isometry3d camera_in_base(const TipFlags& flags) {
  const ReadHandEye hand_eye = read_hand_eye(flags.hand_eye);
  if (hand_eye.place == EyePlace::to_hand) return hand_eye.camera;

  throw_if(!flags.view, "--view is missing: the robot's pose when the points were measured");
  return read_robot_poses(*flags.view, flags.robot).front() * hand_eye.camera;
}

/// `what`: is compared at each point.
void tell_test(const TouchTest& test, const std::string& what, double tolerance, Output& output) {
  for (std::size_t i = 0; i < test.differences.size(); ++i) {
    output.say("point {}: {} {}", i + 1, what, signed_text_of(test.differences[i]));
  }
  output.add("differences_mm", test.differences);
  const std::string error =
      test.standard_error.allFinite()
          ? fmt::format(", standard error {:.3f} mm", test.standard_error.norm())
          : "";
  output.say("mean: {} in the base{}", signed_text_of(test.mean), error);

  output.add("mean_mm", test.mean, "standard_error_mm", test.standard_error.norm(), "rms_mm",
             test.rms, "largest_mm", test.largest);
  const auto [grade, words] = verdict_of(test, tolerance);
  output.tell_verdict(grade, words);
}

void test_touch(const TouchFlags& flags, Output& output) {
  const Eigen::Isometry3d camera = camera_in_base(flags.robot);
  const StoredPoints stored = read_points(flags.points);
  if (stored.frame) {
    throw Error(fmt::format("{}: its points are in the frame {}; give them in the camera's",
                            flags.points, stored.frame->to));
  }

  std::vector<Eigen::Vector3d> points;
  for (const StoredPoint& point : stored.points) points.emplace_back(point.x, point.y, point.z);
  const auto touched = read_robot_poses(flags.robot.touched, flags.robot.robot);
  tell_test(touch_test(points, camera, touched, place_from(flags.robot.tip, "--tip")),
            "camera less tip", flags.robot.tolerance, output);
}

/// A picture for the projector with a ring around each pixel.
Image<std::uint8_t> rings_around(const PixelPlaces& pixels, Size projector) {
  constexpr double radius = 12, half_width = 1.5;
  Image<std::uint8_t> picture(projector);
  for_each_pixel_in_order(projector, [&](int column, int row) {
    for (const Eigen::Vector2d& pixel : pixels) {
      const double distance = (Eigen::Vector2d(column, row) - pixel).norm();
      if (std::abs(distance - radius) < half_width) picture(column, row) = 255;
    }
  });
  return picture;
}

void test_projection(const ProjectionFlags& flags, Output& output) {
  const Eigen::Isometry3d camera = camera_in_base(flags.robot);
  const Eigen::Vector3d tip = place_from(flags.robot.tip, "--tip");
  std::vector<Eigen::Vector3d> points;
  for (const auto& tool : read_robot_poses(flags.robot.touched, flags.robot.robot)) {
    points.emplace_back(tool * tip);
  }

  // 1. Light for the eye: rings about the corners, where the robot has them.
  Scanner scanner = read_scanner(flags.scanner);
  if (!flags.rings.empty()) {
    PixelPlaces pixels;
    for (const Eigen::Vector3d& point : points) {
      const Eigen::Vector3d place = camera.inverse() * point;
      pixels.push_back(project(scanner.projector, in_projector_frame(scanner, place)));
    }
    write_image(flags.rings, rings_around(pixels, scanner.projector.size));
    output.add_file("rings", flags.rings);
  }

  // 2. The same light measured: a scan says which projector pixel lights each corner.
  const CalibrationBoard board = board_from(flags.boards.board);
  BoardCaptureFlags boards = flags.boards;
  boards.capture.projector = scanner.projector.size;
  const PoseCaptures seen = captured_boards(boards, board, scanner.photometry.response, output);
  throw_if(seen.views.size() != 1, "{}: {} poses of the board can be used; expected one{}",
           boards.folder, seen.views.size(),
           seen.unused.empty() ? "" : " (" + seen.unused[0].why + ")");

  scanner = completed(scanner, flags.scanner, seen.camera, seen.projector);
  tell_test(projection_test(seen.views.front(), board, scanner, camera, points),
            "corner less light", flags.robot.tolerance, output);
}

struct StitchFlags {
  std::string hand_eye, first, second, poses, scanner;
  RobotPoseFlags robot;
  double tolerance = 0.5;
};

void test_stitching(const StitchFlags& flags, Output& output) {
  const ReadHandEye hand_eye = read_hand_eye(flags.hand_eye);
  const std::vector<Eigen::Isometry3d> robot = read_robot_poses(flags.poses, flags.robot);
  throw_if(robot.size() != 2, "{} has {} poses; expected those of the two views", flags.poses,
           robot.size());

  // 1. Both cameras in the frame in which the scene rests: the base, or the tool that carries it.
  const bool carried = hand_eye.place == EyePlace::to_hand;
  const Eigen::Isometry3d first = (carried ? robot[0].inverse() : robot[0]) * hand_eye.camera;
  const Eigen::Isometry3d second = (carried ? robot[1].inverse() : robot[1]) * hand_eye.camera;

  // 2. The views on each other.
  const Stitching found = stitched(read_cloud(flags.first).cloud, read_cloud(flags.second).cloud,
                                   read_scanner(flags.scanner).camera, first.inverse() * second);
  const Eigen::Matrix3d to_base = carried ? hand_eye.camera.linear() : first.linear();
  const Eigen::Vector3d offset = to_base * found.offset;

  output.say("{} shared points: median distance {:.3f} mm, 95th percentile {:.3f} mm", found.points,
             found.median, found.percentile_95);
  output.say(
      "the second view lies off the first by {} in the base, turned by {:.4f} degrees; "
      "without that {:.3f} mm remain",
      signed_text_of(offset), found.rotation / degree, found.left_median);

  output.add("points", found.points, "median_mm", found.median, "percentile_95_mm",
             found.percentile_95, "offset_mm", offset, "rotation_degrees", found.rotation / degree,
             "left_median_mm", found.left_median);

  if (offset.norm() <= flags.tolerance) {
    output.tell_verdict("good",
                        fmt::format("Good: the views meet within {:.3f} mm.", offset.norm()));
  } else {
    output.tell_verdict(
        "bad", fmt::format("Calibrate again: the views are {:.3f} mm apart.", offset.norm()));
  }
}

/// `touched`: help of the robot's poses.
void add_tip_flags(const FlagGroup& command, TipFlags& flags, const char* touched) {
  required(command.add_file("hand-eye", flags.hand_eye, "pose file of calibrate hand-eye"));
  required(command.add_file("--touched", flags.touched, touched));
  required(command.add("--tip", flags.tip, "the tip in the tool's frame, mm: x,y,z"));
  command.add_file("--view", flags.view,
                   "the robot's pose when the points were measured, if the camera is on the tool");
  add_robot_pose_flags(command, flags.robot);
  command.add("--tolerance", flags.tolerance, "largest error, mm");
}

}  // namespace

void add_calibrate_touch(const Commands& calibrate) {
  const auto [command, flags] = calibrate.add(
      test_touch, "touch", "check a hand-eye pose: a tip on points that the camera measured");
  add_tip_flags(command, flags.robot,
                "the robot's poses with the tip on each point, in the same order");
  required(command.add_file("--points", flags.points,
                            "the points in the camera's frame, mm: .xyz, .csv, .ply, ..."));
  command.examples(
      {"calibrate touch camera.yaml --points points.xyz --touched touched.csv --view "
       "view.csv --tip 0,0,150 --robot-convention 'kuka, mm, tool to base'"});
}

void add_calibrate_projection(const Commands& calibrate) {
  const auto [command, flags] =
      calibrate.add(test_projection, "projection",
                    "check a hand-eye pose: light on a board's corners, where the robot has them");
  add_tip_flags(command, flags.robot,
                "the robot's poses with the tip on outer corners of the board, in any order");
  required(command.add_file("--boards", flags.boards.folder,
                            "folder with one pose of the board, as for calibrate geometry"));
  required(command.add_file("--scanner", flags.scanner, "scanner file"));
  command.add_output("--rings", flags.rings,
                     "picture for the projector with a ring about each point: .png");
  add_board_flags(command.app, flags.boards.board);
  add_scan_flags(command.app, flags.boards.scan);
  command.app.remove_option(command.app.get_option("--axis"));
}

void add_calibrate_stitch(const Commands& calibrate) {
  const auto [command, flags] = calibrate.add(
      test_stitching, "stitch", "check a hand-eye pose: two views of one scene must meet");
  required(command.add_file("hand-eye", flags.hand_eye, "pose file of calibrate hand-eye"));
  required(command.add_file("first", flags.first, "cloud of the first view: .pcd"));
  required(command.add_file("second", flags.second, "cloud of the second view: .pcd"));
  required(command.add_file("--poses", flags.poses, "the robot's poses at both views"));
  required(command.add_file("--scanner", flags.scanner, "scanner file of the clouds"));
  add_robot_pose_flags(command, flags.robot);
  command.add("--tolerance", flags.tolerance, "largest distance between the views, mm");
}

}  // namespace slipstream::app
