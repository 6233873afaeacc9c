#include <numbers>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "app/board_captures.h"
#include "app/commands.h"
#include "app/finding_output.h"
#include "slipstream/base/error.h"
#include "slipstream/calibrate/verification.h"
#include "slipstream/io/scanner_file.h"

namespace slipstream::app {
namespace {

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

void verify(const CalibrateVerifyFlags& flags, Output& output) {
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

void add_calibrate_verify(CLI::App& calibrate, Command& chosen) {
  const auto [command, flags] =
      add_command(calibrate, chosen, verify, "verify",
                  "whether a scanner file still holds, by scans of a board; corrects its pose");
  command.add_file("--scanner", flags.scanner, "the scanner file")->required();
  command.add_scanner_output("-o,--output", flags.output,
                             "where it does not hold, the corrected scanner file: .yaml or .xml");
  add_board_capture_flags(command, flags.boards);
  command.app.footer(
      "Example:\n  slipstream calibrate verify poses --scanner scanner.yaml --corners 13x9 "
      "--spacing 10 -o corrected.yaml");
}

}  // namespace slipstream::app
