// calibrate board and calibrate verify: print a board; check a scanner file with board scans.
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/board_flags.h"
#include "app/commands.h"
#include "app/findings.h"
#include "app/scan_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/calibrate/verification.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scanner_file.h"

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
  if (!(flags.dots_per_inch > 0 && flags.dots_per_inch <= 10000)) {
    throw Error(
        fmt::format("--dpi {} is out of range; more than 0, at most 10000", flags.dots_per_inch));
  }
  // Whole pixels for each spacing keep all edges sharp; the page's size in mm says the rest.
  const int pixels_per_spacing =
      static_cast<int>(std::lround(board.spacing / mm_per_inch * flags.dots_per_inch));
  const Image<std::uint8_t> picture = draw_board(board, pixels_per_spacing);
  write_image(flags.file, picture);
  const double mm_per_pixel = board.spacing / pixels_per_spacing;
  const double width = picture.width() * mm_per_pixel, height = picture.height() * mm_per_pixel;
  output.say("wrote a {} of {}x{} to {}, {} pixels", name_of(board.kind), board.columns, board.rows,
             flags.file, text_of(picture.size()));
  output.say("print it {:.2f} mm x {:.2f} mm (no 'fit to page'), and measure what was printed",
             width, height);
  output.document = {{"board", flags.file},
                     {"width_px", picture.width()},
                     {"height_px", picture.height()},
                     {"width_mm", width},
                     {"height_mm", height}};
}

struct CalibrateVerifyFlags {
  BoardCaptureFlags boards;
  std::string scanner;
  std::optional<std::string> output;
};

nlohmann::json json_of_measure(const BoardMeasure& measure) {
  return {{"epipolar_px", measure.epipolar},
          {"rms",
           {{"camera", measure.rms.camera},
            {"projector", measure.rms.projector},
            {"stereo", measure.rms.stereo}}},
          {"flatness_mm", measure.quality.flatness},
          {"scale_error", measure.quality.scale_error}};
}

void say_measure(const std::string& what, const BoardMeasure& measure, Output& output) {
  output.say(
      "{}: epipolar distance {:.3f} px, RMS {:.3f} px, flat to {:.4f} mm, scale error {:.3f} %",
      what, measure.epipolar, measure.rms.stereo, measure.quality.flatness,
      100 * measure.quality.scale_error);
}

/// Writes the corrected scanner where it is asked for and there is something to correct.
void write_corrected(const CalibrateVerifyFlags& flags, const Verification& found,
                     Scanner corrected, Output& output) {
  if (!flags.output) return;
  if (found.holds) {
    output.say("{} is not written: there is nothing to correct", *flags.output);
    return;
  }
  if (!found.mended) {
    throw Error(
        fmt::format("{} is not written: {}", *flags.output, text_of(found.findings.back())));
  }
  if (!corrected.measured.empty()) corrected.measured += "; ";
  corrected.measured += fmt::format("pose corrected by {} boards", found.poses.size());
  write_scanner(*flags.output, corrected);
  output.document["output"] = *flags.output;
  output.say("the corrected scanner file is {}", *flags.output);
}

void verify_calibration(const CalibrateVerifyFlags& flags, Output& output) {
  const CalibrationBoard board = board_from(flags.boards.board);
  const Scanner read = read_scanner(flags.scanner);
  const PoseCaptures captures =
      captured_boards(flags.boards, board, read.photometry.response, output);
  if (captures.views.empty()) {
    throw Error(fmt::format("{}: no pose can be used{}", flags.boards.folder,
                            captures.unused.empty() ? "" : " (" + captures.unused[0].why + ")"));
  }
  const Verification found = verify_scanner(
      captures.views, board, completed(read, flags.scanner, captures.camera, captures.projector));

  output.document = {{"scanner", flags.scanner},
                     {"holds", found.holds},
                     {"mended", found.mended},
                     {"before", json_of_measure(found.before)},
                     {"after", json_of_measure(found.after)},
                     {"rotation_rad", found.rotation},
                     {"translation_mm", found.translation},
                     {"poses", nlohmann::json::array()}};
  for (const VerifiedPose& pose : found.poses) {
    output.list("poses").push_back({{"name", pose.name},
                                    {"before", json_of_measure(pose.before)},
                                    {"after", json_of_measure(pose.after)}});
  }
  std::vector<Finding> findings = captures.findings;
  findings.insert(findings.end(), found.findings.begin(), found.findings.end());
  output.document["findings"] = app::json_of(findings);
  warn_of(findings, output);
  say_measure("as it is", found.before, output);
  say_measure("corrected", found.after, output);
  output.say("the correction turns the projector by {:.3f} degrees and moves it by {:.3f} mm",
             found.rotation * 180 / std::numbers::pi, found.translation);
  output.say("{} {}", flags.scanner,
             found.holds    ? "holds"
             : found.mended ? "does not hold; corrected, it does"
                            : "does not hold, nor does it corrected");
  write_corrected(flags, found, found.corrected, output);
}

}  // namespace

void add_calibrate_board(CLI::App& calibrate, Command& chosen) {
  const auto [command, flags] =
      add_command(calibrate, chosen, write_board, "board", "draw a calibration board to print");
  command.add_output("-o,--output", flags.file, "the picture: .png, .tiff, .bmp or .pgm")
      ->required();
  command.add("--dpi", flags.dots_per_inch, "pixels for each inch of paper");
  add_board_flags(command.app, flags.board);
  command.app.footer(
      "Example:\n  slipstream calibrate board --board chessboard --corners 13x9 --spacing 15 -o "
      "board.png");
}

void add_calibrate_verify(CLI::App& calibrate, Command& chosen) {
  const auto [command, flags] =
      add_command(calibrate, chosen, verify_calibration, "verify",
                  "whether a scanner file still holds, by scans of a board; corrects its pose");
  command.add_file("--scanner", flags.scanner, "the scanner file")->required();
  command.add_scanner_output("-o,--output", flags.output,
                             "where it does not hold, the corrected scanner file: .yaml or .xml");
  add_board_capture_flags(command, flags.boards);
  command.app.footer(
      "Example:\n  slipstream calibrate verify poses --scanner scanner.yaml --corners 13x9 "
      "--spacing 10 -o corrected.yaml");
}

void add_calibrate(CLI::App& program, Command& chosen) {
  CLI::App* calibrate = program.add_subcommand("calibrate", "find out what a real rig is like");
  calibrate->require_subcommand(1);
  add_calibrate_board(*calibrate, chosen);
  add_calibrate_geometry(*calibrate, chosen);
  add_calibrate_verify(*calibrate, chosen);
  add_calibrate_gamma(*calibrate, chosen);
  add_calibrate_ambient(*calibrate, chosen);
  add_calibrate_noise(*calibrate, chosen);
  add_calibrate_colour(*calibrate, chosen);
  add_calibrate_height(*calibrate, chosen);
}

}  // namespace slipstream::app
