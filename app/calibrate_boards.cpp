#include "app/calibrate_boards.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/calibrate_repeat.h"
#include "app/flag_names.h"
#include "app/report_facts.h"
#include "app/scan_flags.h"
#include "calibrate/board_view.h"
#include "calibrate/report.h"
#include "calibrate/several_cameras.h"
#include "io/file_names.h"
#include "io/image_file.h"
#include "io/point_lists.h"
#include "io/print_file.h"
#include "io/scan_folder.h"
#include "io/scan_pictures.h"
#include "slipstream/scan_files.h"

namespace slipstream::app {
namespace {

struct CalibrateBoardFlags {
  BoardFlags board;
  std::string file;
  double dots_per_inch = 600;
};

void write_board(const CalibrateBoardFlags& flags, Output& output) {
  const CalibrationBoard board = board_from(flags.board);
  constexpr double mm_per_inch = 25.4;
  require_in_range(flags.dots_per_inch > 0 && flags.dots_per_inch <= 10000, "--dpi",
                   flags.dots_per_inch, "more than 0, at most 10000");

  // A whole number of pixels per spacing keeps edges sharp; the page size in mm sets the scale.
  const int pixels_per_spacing =
      static_cast<int>(std::lround(board.spacing / mm_per_inch * flags.dots_per_inch));
  const Image<std::uint8_t> picture = draw_board(board, pixels_per_spacing);
  const double mm_per_pixel = board.spacing / pixels_per_spacing;

  write_print(flags.file, picture, mm_per_pixel);
  const double width = picture.width() * mm_per_pixel, height = picture.height() * mm_per_pixel;
  output.say("wrote a board ({}, {}x{}) to {}, {} pixels", name_of(board.kind), board.columns,
             board.rows, flags.file, text_of(picture.size()));
  output.say("print it at {:.2f} mm x {:.2f} mm, without 'fit to page', then measure the print",
             width, height);

  output.document = described("board", flags.file, "width_px", picture.width(), "height_px",
                              picture.height(), "width_mm", width, "height_mm", height);
}

void add_board_capture_flags(const FlagGroup& command, BoardCaptureFlags& flags) {
  required(command.add_file("folder", flags.folder,
                            "folder with a subfolder per pose: scans x and y (folders, or "
                            "recordings x.slip and y.slip), or the pictures of both"));

  command.add("--exclude", flags.excluded, "names of poses to ignore");
  command.add("--first-axis", flags.first_axis,
              "if both scans lie in one folder: the axis whose pictures come first, x or y");

  command.add("--minimum-modulation", flags.capture.minimum_modulation,
              "minimum modulation for a pixel's phase to be used, grey levels of 255");
  command.add("--neighbourhood", flags.capture.neighbourhood,
              "radius around a corner within which phase is used, in corner spacings");

  add_board_flags(command.app, flags.board);
  add_scan_flags(command.app, flags.scan);
  command.app.remove_option(command.app.get_option("--axis"));
}

struct CalibrateVerifyFlags {
  BoardCaptureFlags boards;
  std::string scanner;
  std::optional<std::string> output;
  RepeatFlags repeat;
};

nlohmann::json json_of(const BoardMeasure& measure) {
  return described("epipolar_px", measure.epipolar, "rms", json_of_rms(measure.rms), "flatness_mm",
                   measure.quality.flatness, "scale_error", measure.quality.scale_error);
}

void say_measure(const std::string& what, const BoardMeasure& measure, Output& output) {
  output.say(
      "{}: epipolar distance {:.3f} px, RMS {:.3f} px, flat to {:.4f} mm, scale error {:.3f} %",
      what, measure.epipolar, measure.rms.stereo, measure.quality.flatness,
      100 * measure.quality.scale_error);
}

/// Writes the corrected scanner if requested and if there is something to correct.
void write_corrected(const CalibrateVerifyFlags& flags, const Verification& found, Output& output) {
  if (!flags.output) return;
  if (found.holds) return output.say("{} was not written: nothing to correct", *flags.output);
  if (!found.mended) {
    throw Error(
        fmt::format("{} was not written: {}", *flags.output, text_of(found.findings.back())));
  }

  Scanner corrected = found.corrected;
  if (!corrected.measured.empty()) corrected.measured += "; ";
  corrected.measured += fmt::format("pose corrected by {} boards", found.poses.size());

  write_scanner(*flags.output, corrected);
  output.document["output"] = *flags.output;
  output.say("the corrected scanner file is {}", *flags.output);
}

void verify_calibration(const CalibrateVerifyFlags& flags, Output& output) {
  if (flags.repeat.minutes) {
    RepeatFlags repeat = flags.repeat;
    repeat.capture.source.scanner = flags.scanner;
    repeat.capture.source.sequence = flags.boards.scan.sequence;
    repeat.capture.source.sequence.marker = flags.repeat.capture.source.sequence.marker;
    return verify_over_time(repeat, output);
  }
  throw_if(flags.boards.folder.empty(),
           "nothing to verify: name a folder of board poses, or give --repeat and --source");

  const CalibrationBoard board = board_from(flags.boards.board);
  const Scanner read = read_scanner(flags.scanner);

  // Scans that do not give the projector's size take it from the scanner file.
  BoardCaptureFlags boards = flags.boards;
  boards.capture.projector = read.projector.size;
  const PoseCaptures captures = captured_boards(boards, board, read.photometry.response, output);
  throw_if(captures.views.empty(), "{}: no pose can be used{}", flags.boards.folder,
           captures.unused.empty() ? "" : " (" + captures.unused[0].why + ")");

  // Verification refits the pose of the projector and compares the boards before and after.
  const Verification found = verify_scanner(
      captures.views, board, completed(read, flags.scanner, captures.camera, captures.projector));

  output.document =
      described("scanner", flags.scanner, "holds", found.holds, "mended", found.mended, "before",
                json_of(found.before), "after", json_of(found.after), "rotation_rad",
                found.rotation, "translation_mm", found.translation);
  output.document["poses"] = as_json(found.poses, [](const VerifiedPose& pose) {
    return described("name", pose.name, "before", json_of(pose.before), "after",
                     json_of(pose.after));
  });

  std::vector<Finding> findings = captures.findings;
  findings.insert(findings.end(), found.findings.begin(), found.findings.end());
  output.document["findings"] = findings;
  output.warn(findings);

  say_measure("uncorrected", found.before, output);
  say_measure("corrected", found.after, output);
  output.say("the correction turns the projector by {:.3f} degrees and moves it by {:.3f} mm",
             found.rotation * 180 / std::numbers::pi, found.translation);
  output.say("{} {}", flags.scanner,
             found.holds    ? "holds"
             : found.mended ? "is wrong; the corrected pose is right"
                            : "is wrong, and a corrected pose does not help");

  write_corrected(flags, found, output);
}

/// The corners of all poses, as other programs read them.
std::vector<PosePoints> points_of(const BoardViews& views, const CalibrationBoard& board) {
  const BoardPlaces printed = printed_places(board);
  std::vector<PosePoints> poses;
  for (const BoardView& view : views) {
    PosePoints pose{view.name, {}, view.camera, view.projector};
    for (const int place : view.places) pose.board.push_back(printed[place]);
    poses.push_back(std::move(pose));
  }
  return poses;
}

/// The boards that a camera saw, and its calibration from them.
struct CameraAlone {
  PoseCaptures captures;
  GeometryCalibration calibration;
};

/// A further camera of the same projector.
struct FurtherCamera {
  std::string folder;            ///< of its poses
  CalibrationResultFlags files;  ///< its scanner file and report
  std::optional<MeasuredResponse> response;
};

/// The response in a scanner file that will be overwritten; nullopt without one.
std::optional<MeasuredResponse> response_in(const std::string& scanner) {
  if (!fs::exists(scanner)) return std::nullopt;
  return read_photometric_calibration(scanner).response;
}

/// The cameras of --more-cameras. Throws Error if an existing scanner file of one cannot be read,
/// WorldError if it cannot be written.
std::vector<FurtherCamera> further_cameras(const CalibrateGeometryFlags& flags) {
  std::vector<FurtherCamera> cameras;
  for (const std::string& folder : flags.more_cameras) {
    const int number = static_cast<int>(cameras.size()) + 2;
    CalibrationResultFlags files = flags.result;
    files.scanner = numbered(files.scanner, number).string();
    if (files.report) files.report = numbered(*files.report, number).string();

    static_cast<void>(output_target(files.scanner));
    cameras.push_back({folder, files, response_in(files.scanner)});
  }
  return cameras;
}

nlohmann::json json_of(const CameraPose& camera) {
  const Eigen::AngleAxisd turn(camera.pose.linear());
  const Eigen::Vector3d rotation = turn.angle() * turn.axis();
  return described("rotation_rad", rotation, "rotation_deviation_rad", camera.rotation_sigma,
                   "translation_mm", Eigen::Vector3d(camera.pose.translation()),
                   "translation_deviation_mm", camera.translation_sigma);
}

void say_pose(const CameraPose& camera, std::size_t number, Output& output) {
  output.say(
      "camera {} is {:.3f} mm from camera 1; its position is known to {:.3f} mm, its direction to "
      "{:.4f} degrees",
      number, camera.pose.translation().norm(), camera.translation_sigma.norm(),
      camera.rotation_sigma.norm() * 180 / std::numbers::pi);
}

/// Calibrates the first camera and the further ones together, and writes a scanner file and a
/// report for each.
void calibrate_cameras(const CalibrateGeometryFlags& flags, const CalibrationBoard& board,
                       CameraAlone first, const std::vector<FurtherCamera>& further,
                       Output& output) {
  const GeometryCalibrationSettings settings = settings_from(flags.result);

  // 1. Each camera alone.
  std::vector<PoseCaptures> captures{std::move(first.captures)};
  std::vector<GeometryCalibration> alone{std::move(first.calibration)};
  for (const FurtherCamera& camera : further) {
    BoardCaptureFlags boards = flags.boards;
    boards.folder = camera.folder;
    captures.push_back(captured_boards(boards, board, camera.response, output));
    require_enough_poses(captures.back(), camera.folder);
    alone.push_back(calibrate_geometry(captures.back().views, board, captures.back().camera,
                                       captures.back().projector, settings));
  }

  // 2. All together, then a scanner file for each.
  const BoardPlaces printed = printed_places(board);
  const CamerasCalibration together =
      calibrate_together(std::move(alone), printed, board.spacing, settings);

  nlohmann::json cameras = nlohmann::json::array();
  for (std::size_t c = 0; c < together.cameras.size(); ++c) {
    const CalibrationResultFlags& files = c > 0 ? further[c - 1].files : flags.result;
    if (c > 0) say_pose(together.poses[c - 1], c + 1, output);

    write_calibration(
        files,
        {together.cameras[c], printed, text_of(board), captures[c].unused, captures[c].findings},
        std::nullopt, output);
    if (c > 0) output.document["pose"] = json_of(together.poses[c - 1]);
    cameras.push_back(std::exchange(output.document, {}));
  }

  // The first camera's figures stand as without the others.
  output.document = cameras.front();
  cameras.erase(cameras.begin());
  output.document["more_cameras"] = cameras;
}

/// The camera's temperatures in the poses whose scan.yaml has them, from least to most.
Facts temperatures_in(const fs::path& folder, const BoardViews& views) {
  std::map<std::string, std::vector<double>> known;
  for (const BoardView& view : views) {
    const fs::path file = folder / view.name / "x" / "scan.yaml";
    if (!fs::exists(file)) continue;
    for (const auto& [part, celsius] : read_scan_files(file).temperatures) {
      known[part].push_back(celsius);
    }
  }

  Facts facts;
  for (const auto& [part, celsius] : known) {
    const auto [least, most] = std::ranges::minmax(celsius);
    add_temperature(facts, part, least, most);
  }
  return facts;
}

std::vector<Finding> measured_findings(const CalibrateGeometryFlags& flags,
                                       const CalibrationBoard& board) {
  if (!flags.measured) return {};
  const std::vector<double> lengths = lengths_from(*flags.measured, "--measured");

  throw_if(lengths.size() != 2,
           "--measured {}: expected two lengths, of a row and of a column, e.g. 121.9x80.3",
           *flags.measured);
  return findings_of_ruler(board, {lengths[0], lengths[1]});
}

}  // namespace

PoseCaptures captured_boards(const BoardCaptureFlags& flags, const CalibrationBoard& board,
                             const std::optional<MeasuredResponse>& response, Output& output) {
  const std::vector<BoardScans> poses =
      board_scans(flags.folder, flags.scan, axis_named(flags.first_axis));

  BoardCaptureSettings settings = flags.capture;
  settings.response = response;
  if (response) {
    output.say("phases are corrected for the scanner file's response, gamma {:.5g}",
               response->gamma);
  }

  Progress progress("poses", poses.size());
  PoseCaptures captures = capture_poses(flags.folder, poses, flags.excluded, board, settings,
                                        [&](const std::string& words) {
                                          if (!words.empty()) output.say("{}", words);
                                          progress.advance();
                                        });

  output.warn(captures.warnings);
  return captures;
}

void calibrate_boards(const CalibrateGeometryFlags& flags, Output& output) {
  const CalibrationBoard board = board_from(flags.boards.board);
  const GeometryCalibrationSettings settings = settings_from(flags.result);
  std::vector<Finding> findings = measured_findings(flags, board);

  // Read the files first: errors in them should not wait for the calibration.
  const std::optional<Scanner> other = compared_scanner(flags.result);
  const std::optional<MeasuredResponse> response = response_in(flags.result.scanner);
  const std::vector<FurtherCamera> further = further_cameras(flags);

  // 1. Find the board's corners in every pose, in camera pixels and projector coordinates.
  const PoseCaptures captures = captured_boards(flags.boards, board, response, output);
  require_enough_poses(captures, flags.boards.folder);
  if (flags.points) write_point_list(*flags.points, points_of(captures.views, board));

  // 2. Calibrate both lenses and the pose between them.
  output.tell_wait("calibrating");
  const GeometryCalibration calibration =
      calibrate_geometry(captures.views, board, captures.camera, captures.projector, settings);

  // 3. Write the scanner file and the report, with all diagnostics together.
  if (!further.empty()) {
    calibrate_cameras(flags, board, {captures, calibration}, further, output);
  } else {
    findings.insert(findings.end(), captures.findings.begin(), captures.findings.end());
    write_calibration(flags.result,
                      {calibration, printed_places(board), text_of(board), captures.unused,
                       std::move(findings), temperatures_in(flags.boards.folder, captures.views)},
                      other, output);
  }
  if (flags.points) output.say("points: {}", *flags.points);
}

void add_calibrate_board(const Commands& calibrate) {
  const auto [command, flags] =
      calibrate.add(write_board, "board", "draw a calibration board to print");
  required(command.add_output("-o,--output", flags.file,
                              "the board at true size with a ruler: .pdf or .svg; as a picture: "
                              ".png, .tiff, .bmp or .pgm"));

  command.add("--dpi", flags.dots_per_inch, "pixels for each inch of paper");
  add_board_flags(command.app, flags.board);
  command.examples({"calibrate board --board chessboard --corners 13x9 --spacing 15 -o board.pdf"});
}

void add_calibrate_verify(const Commands& calibrate) {
  const auto [command, flags] =
      calibrate.add(verify_calibration, "verify",
                    "check a scanner file against scans of a board, and correct its pose");
  required(command.add_file("--scanner", flags.scanner, "the scanner file"));
  command.add_output("-o,--output", flags.output,
                     "corrected scanner file, written if the old one is wrong: .yaml or .xml",
                     scanner_output_type);

  add_board_capture_flags(command, flags.boards);
  add_repeat_flags(command, flags.repeat);
  command.app.get_option("folder")->required(false);
  command.exclude("--repeat",
                  {"folder", "--output", "--exclude", "--first-axis", "--minimum-modulation",
                   "--neighbourhood", "--board", "--corners", "--spacing", "--circle-diameter",
                   "--marker-side", "--dictionary", "--order", "--channel", "--mosaic"});

  command.common({"--scanner", "--output", "--repeat", "--source", "--monitor", "--report",
                  "--board", "--corners", "--spacing", "--strategy", "--steps", "--high", "--low",
                  "--projector"});
  command.examples(
      {"calibrate verify poses --scanner scanner.yaml --corners 13x9 --spacing 10 -o "
       "corrected.yaml",
       "calibrate verify --repeat 60 --source aravis: --monitor 1 --scanner scanner.yaml --report "
       "warm-up"});
}

void add_calibrate(const Commands& program) {
  const Commands calibrate = program.add_group(
      "calibrate", "calibrate a rig: geometry, response, noise, ambient light, colour, robot");

  // In the order of the help.
  for (AddCommand* const add :
       {add_calibrate_board, add_calibrate_geometry, add_calibrate_points, add_calibrate_verify,
        add_calibrate_gamma, add_calibrate_ambient, add_calibrate_noise, add_calibrate_colour,
        add_calibrate_height, add_calibrate_residual, add_calibrate_hand_eye, add_calibrate_touch,
        add_calibrate_projection, add_calibrate_stitch, add_calibrate_virtual_robot}) {
    add(calibrate);
  }
}

void add_calibrate_geometry(const Commands& calibrate_command) {
  const auto [command, flags] = calibrate_command.add(
      calibrate_boards, "geometry",
      "calibrate camera and projector from scans of a board in several poses");
  add_result_flags(command, flags.result);
  command
      .add("--more-cameras", flags.more_cameras,
           "folders of the same poses as further cameras of this projector took them: all are "
           "calibrated together, into scanner-2.yaml and so on beside --output")
      ->type_name(file_type);
  command.add_output("--save-points", flags.points,
                     "write the points that were found, for other programs: .csv");

  command.add("--measured", flags.measured,
              "measured on the print with a ruler, first to last corner, mm: row x column");

  add_board_capture_flags(command, flags.boards);
  add_model_flags({command.app, "Model"}, flags.result);

  command.exclude("--more-cameras", {"--compare", "--measured", "--residual"});
  command.common({"--output", "--report", "--board", "--corners", "--spacing", "--strategy",
                  "--steps", "--high", "--low", "--projector"});
  command.examples(
      {"calibrate geometry poses --board chessboard --corners 13x9 --spacing 10 --strategy "
       "dual-frequency --steps 3 --high 16 --low 1 --projector 1824x1140 -o scanner.yaml --report "
       "report"});
}

}  // namespace slipstream::app
