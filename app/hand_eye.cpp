#include "calibrate/hand_eye.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/calibrate_boards.h"
#include "app/commands.h"
#include "app/hand_eye.h"
#include "app/report_facts.h"
#include "app/scan_flags.h"
#include "base/numbers.h"
#include "calibrate/hand_eye_boards.h"
#include "calibrate/hand_eye_report.h"
#include "calibrate/report.h"
#include "calibrate/virtual_robot.h"
#include "io/image_file.h"
#include "io/pose_file.h"
#include "io/pose_table_file.h"
#include "io/scan_pictures.h"
#include "slipstream/scanner_file.h"

namespace slipstream::app {
namespace {

constexpr std::string_view in_hand = "in-hand", to_hand = "to-hand";

EyePlace eye_place_named(std::string_view name) {
  if (name == in_hand) return EyePlace::in_hand;
  if (name == to_hand) return EyePlace::to_hand;
  throw Error(
      fmt::format("--eye {} is unknown; expected in-hand (camera on the tool) or to-hand "
                  "(camera beside the robot, board on the tool)",
                  name));
}

const char* const convention_help =
    "known parts of the robot's convention; the rest is found: a robot (abb, doosan, fanuc, "
    "franka, kawasaki, kuka, ur, yaskawa) or parts such as 'intrinsic zyx in degrees, mm, tool to "
    "base'";

struct HandEyeFlags {
  std::string robot, boards, columns, robot_convention, board_convention, output;
  EyePlace place = EyePlace::in_hand;
  BoardFlags board;
  ScanChanges scan;
  std::optional<std::string> scanner, report;
};

/// A table with a row for each name, in natural order; those without a board have no numbers.
PoseTable with_missing(const PoseTable& found, const std::vector<std::string>& missing) {
  std::map<std::string, std::vector<double>> rows;
  for (std::size_t i = 0; i < found.names.size(); ++i) rows[found.names[i]] = found.rows[i];
  for (const std::string& name : missing) rows[name] = std::vector<double>(16, nan);

  PoseTable all;
  for (const auto& [name, row] : rows) all.names.push_back(name);
  std::ranges::sort(all.names, before_in_order);
  for (const std::string& name : all.names) all.rows.push_back(rows[name]);
  return all;
}

/// The boards in pictures of the camera alone.
PoseTable boards_in_pictures(const HandEyeFlags& flags, const CalibrationBoard& board,
                             const Scanner& scanner, Output& output) {
  BoardViews views;
  std::vector<std::string> missing;
  const std::vector<fs::path> files = images_in_folder(flags.boards);
  Progress progress("pictures", files.size());

  for (const fs::path& file : files) {
    const Image<double> levels = read_levels(file);
    throw_if(levels.size() != scanner.camera.size, "{} has {} pixels; the scanner's camera has {}",
             file.string(), text_of(levels.size()), text_of(scanner.camera.size));
    Image<float> picture(levels.size());
    std::ranges::copy(levels, picture.begin());

    const std::string name = file.stem().string();
    const auto view = board_in_picture(name, board, picture);
    output.say("{}: {}", name, view ? "board found" : "no board");
    if (view) {
      views.push_back(*view);
    } else {
      missing.push_back(name);
    }
    progress.advance();
  }
  return with_missing(board_table(std::move(views), board, scanner), missing);
}

/// The boards in scans, a folder for each pose.
PoseTable boards_in_scans(const HandEyeFlags& flags, const CalibrationBoard& board,
                          const Scanner& scanner, Output& output) {
  BoardCaptureFlags capture;
  capture.folder = flags.boards;
  capture.board = flags.board;
  capture.scan = flags.scan;
  capture.capture.projector = scanner.projector.size;
  const PoseCaptures captures =
      captured_boards(capture, board, scanner.photometry.response, output);

  std::vector<std::string> missing;
  for (const UnusedPose& pose : captures.unused) missing.push_back(pose.name);
  const Scanner whole = completed(scanner, *flags.scanner, captures.camera, captures.projector);
  return with_missing(board_table(captures.views, board, whole), missing);
}

PoseTable boards_from(const HandEyeFlags& flags, Output& output) {
  if (!fs::is_directory(flags.boards)) return read_pose_table(flags.boards);

  throw_if(!flags.scanner, "--scanner is missing: boards in scans or pictures need its lens");
  const CalibrationBoard board = board_from(flags.board);
  const Scanner scanner = read_scanner(*flags.scanner);
  const bool has_folders =
      std::ranges::any_of(fs::directory_iterator(flags.boards),
                          [](const fs::directory_entry& entry) { return entry.is_directory(); });
  return has_folders ? boards_in_scans(flags, board, scanner, output)
                     : boards_in_pictures(flags, board, scanner, output);
}

nlohmann::json json_of(const std::optional<HandEyeError>& error) {
  if (!error) return {};
  return described("mm", error->translation, "degrees", error->rotation / degree);
}

nlohmann::json document_of(const HandEye& found) {
  const FramePose camera{"camera", carrier_of_camera(found.place), found.poses.camera};

  nlohmann::json document = described(
      "from", camera.from, "to", camera.to, "matrix", app::json_of(camera)["matrix_mm"],
      "translation_deviation_mm", found.translation_deviation, "rotation_deviation_degrees",
      Eigen::Vector3d(found.rotation_deviation / degree), "robot_convention",
      name_of(found.robot, robot_frames), "board_convention", name_of(found.boards, board_frames),
      "mean_error", json_of(found.mean), "mean_left_out", json_of(found.mean_left_out),
      "board_size", found.scale, "board_size_deviation", found.scale_deviation, "findings",
      found.findings, "verdict", verdict_of(found.findings).words);

  document["poses"] = as_json(found.each, [](const HandEyePose& pose) {
    return described("name", pose.name, "used", pose.used, "reason", pose.reason, "error",
                     json_of(pose.error), "left_out", json_of(pose.left_out));
  });
  document["more_poses"] = as_json(found.more, [](const MorePoses& more) {
    return described("poses", more.which, "translation_deviation_mm", more.translation,
                     "rotation_deviation_degrees", more.rotation / degree);
  });
  return document;
}

void calibrate_robot(const HandEyeFlags& flags, Output& output) {
  const PoseTable robot = read_pose_table(flags.robot, flags.columns);
  const bool measured_here = fs::is_directory(flags.boards);
  HandEyeSettings settings{
      .place = flags.place, .robot = flags.robot_convention, .boards = flags.board_convention};
  if (measured_here) settings.boards = name_of(board_table_convention(), board_frames);

  const HandEye found = calibrate_hand_eye(robot, boards_from(flags, output), settings);
  output.document = document_of(found);
  output.say_lines(text_of(found));
  output.warn(found.findings);

  if (flags.report) {
    const fs::path folder = *flags.report;
    Page page = hand_eye_report(found, &with_flags);
    page.heading("Run");
    page.facts(facts_of_run(output));
    write_page(folder / "report.html", page);

    // JSON is YAML, too.
    write_file(
        folder / "residuals.yaml",
        output.document["poses"].dump(2, ' ', false, nlohmann::json::error_handler_t::replace) +
            '\n');
    output.say("report: {}", (folder / "report.html").string());
    output.document["report"] = *flags.report;
  }

  write_pose(flags.output, {"camera", carrier_of_camera(flags.place), found.poses.camera});
  output.say("{}", verdict_of(found.findings).words);
  output.say("camera to {}: {}", carrier_of_camera(flags.place), flags.output);
  output.document["output"] = flags.output;
}

struct VirtualRobotFlags {
  std::string folder, robot_convention = "kuka, mm, tool to base";
  VirtualRobot robot;
  double degrees = 0.01;
};

/// Column names of a table in this notation.
std::string columns_of(const RotationNotation& notation) {
  switch (notation.kind) {
    case RotationNotation::Kind::quaternion:
      return "x,y,z,q1,q2,q3,q4";
    case RotationNotation::Kind::matrix:
      return "m1,m2,m3,m4,m5,m6,m7,m8,m9,m10,m11,m12,m13,m14,m15,m16";
    default:
      return "x,y,z,rx,ry,rz";
  }
}

void write_virtual_robot(const VirtualRobotFlags& flags, Output& output) {
  // 1. The first way of writing poses that agrees with the flag.
  std::optional<PoseConvention> convention;
  for (const std::size_t numbers : {6U, 7U, 16U}) {
    try {
      convention = conventions_of(numbers, robot_frames, flags.robot_convention).front();
      break;
    } catch (const Error&) {
      if (numbers == 16) throw;
    }
  }

  VirtualRobot robot = flags.robot;
  robot.rotation_error = flags.degrees * degree;
  const RobotRun run = moved_robot(robot);
  const fs::path folder = flags.folder;
  make_folder(folder);

  const auto write = [&](const char* name, const std::vector<Eigen::Isometry3d>& poses,
                         const PoseConvention& as) {
    write_file(folder / name, text_of(table_of(poses, as), columns_of(as.rotation)));
  };

  // 2. Poses as robot and camera report them, and the truth.
  const PoseConvention vectors{.rotation = {.kind = RotationNotation::Kind::vector}};
  std::vector<Eigen::Isometry3d> reported, boards;
  for (const PosePair& pair : run.pairs) {
    reported.push_back(pair.robot);
    boards.push_back(pair.board);
  }
  write("robot.csv", reported, *convention);
  write("boards.csv", boards, vectors);
  write_pose(folder / "truth.yaml", {"camera", carrier_of_camera(robot.place), run.truth.camera});

  // 3. A touch test: the tip, 150 mm along the tool's z, on points seen from the first pose.
  const Eigen::Vector3d tip(0, 0, 150);
  const bool on_tool = robot.place == EyePlace::in_hand;
  const Eigen::Isometry3d camera =
      on_tool ? run.pairs.front().robot * run.truth.camera : run.truth.camera;
  std::string points = "x y z\n";
  std::vector<Eigen::Isometry3d> touching;
  for (const double x : {0.0, 90.0, 180.0}) {
    for (const double y : {0.0, 60.0, 120.0}) {
      const Eigen::Vector3d point = run.pairs.front().board * Eigen::Vector3d(x, y, 0);
      points += fmt::format("{:.4f} {:.4f} {:.4f}\n", point.x(), point.y(), point.z());
      const Eigen::Matrix3d turn = run.pairs.front().robot.linear();
      touching.push_back(pose_from(turn, camera * point - turn * tip));
    }
  }
  write("view.csv", {run.pairs.front().robot}, *convention);
  write("touched.csv", touching, *convention);
  write_file(folder / "points.xyz", points);

  output.say("wrote {} poses of a robot, boards, a touch test and the truth to {}", robot.poses,
             flags.folder);
  output.say("robot poses: {}", name_of(*convention, robot_frames));
  output.add("folder", flags.folder, "poses", robot.poses, "robot_convention",
             name_of(*convention, robot_frames));
}

}  // namespace

void add_calibrate_hand_eye(const Commands& calibrate) {
  const auto [command, flags] =
      calibrate.add(calibrate_robot, "hand-eye",
                    "find a camera on a robot's tool or beside it, from poses of robot and board");
  required(command.add_file("robot", flags.robot,
                            "the robot's poses: CSV, YAML or a robot's program, one a line"));
  required(
      command.add_file("boards", flags.boards,
                       "the boards at these poses: their poses in the camera's frame, CSV or "
                       "YAML; or a folder of scans as for calibrate geometry, or of pictures"));
  required(command.add_named("--eye", flags.place, eye_place_named, "",
                             "in-hand (camera on the tool) or to-hand (board on the tool)"));
  required(command.add_output("-o,--output", flags.output, "pose file of the camera: .yaml"));
  command.add_output("--report", flags.report, "folder for a report", output_folder_type);

  command.add("--robot-convention", flags.robot_convention, convention_help);
  command.add("--board-convention", flags.board_convention,
              "the same for the boards' poses, with 'board to camera' or 'camera to board'");
  command.add("--table-columns", flags.columns, columns_help);
  command.add_file("--scanner", flags.scanner, "scanner file, for boards in scans or pictures");

  add_board_flags(command.app, flags.board);
  add_scan_flags(command.app, flags.scan);
  command.app.remove_option(command.app.get_option("--axis"));
  command.common({"--eye", "--output", "--report", "--robot-convention", "--scanner", "--corners",
                  "--spacing"});
  command.examples({"calibrate hand-eye robot.csv boards.csv --eye in-hand -o camera.yaml"});
}

void add_calibrate_virtual_robot(const Commands& calibrate) {
  const auto [command, flags] = calibrate.add(
      write_virtual_robot, "virtual-robot",
      "write poses of a virtual robot and of boards, to rehearse hand-eye calibration");
  required(command.add_output("folder", flags.folder, "folder to write", output_folder_type));
  command.add_named("--eye", flags.robot.place, eye_place_named, in_hand,
                    "in-hand (camera on the tool) or to-hand (board on the tool)");
  command.add("--robot-convention", flags.robot_convention, "how the robot writes its poses");
  command.add("--poses", flags.robot.poses, "number of poses");
  command.add("--robot-error", flags.robot.translation_error,
              "standard deviation of the robot's position along each axis, mm");
  command.add("--robot-turn", flags.degrees,
              "standard deviation of the robot's rotation about each axis, degrees");
  command.add("--corner-error", flags.robot.pixel_error,
              "standard deviation of the board's corners, pixels");
  command.add("--seed", flags.robot.seed, "seed of rig, poses and errors");
  command.examples({"calibrate virtual-robot rehearsal --eye in-hand"});
}

}  // namespace slipstream::app
