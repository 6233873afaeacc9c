#include "app/board_captures.h"

#include "app/progress.h"

namespace slipstream::app {

void add_board_capture_flags(const FlagGroup& command, BoardCaptureFlags& flags) {
  command
      .add_file(
          "folder", flags.folder,
          "holds a folder for each pose: scans x and y (folders, or recordings x.slip and y.slip), "
          "or the pictures of both")
      ->required();
  command.add("--exclude", flags.excluded, "poses to leave out, by name");
  command.add("--first-axis", flags.first_axis,
              "where both scans lie in one folder: x or y, whose pictures come first");
  command.add("--min-modulation", flags.capture.minimum_modulation,
              "least modulation of a pixel whose phase is used, grey levels of 255");
  command.add("--neighbourhood", flags.capture.neighbourhood,
              "radius about a corner in which phase is used, in distances to the next corner");
  add_board_flags(command.app, flags.board);
  add_scan_flags(command.app, flags.scan);
  command.app.remove_option(command.app.get_option("--axis"));
}

PoseCaptures captured_boards(const BoardCaptureFlags& flags, const CalibrationBoard& board,
                             const std::optional<MeasuredResponse>& response, Output& output) {
  const std::vector<BoardScans> poses =
      board_scans(flags.folder, scan_changes_from(flags.scan), axis_named(flags.first_axis));
  BoardCaptureSettings settings = flags.capture;
  settings.response = response;
  if (response) {
    output.say("phases are corrected for the response in the scanner file, gamma {:.5g}",
               response->gamma);
  }
  Progress progress("poses", static_cast<int>(poses.size()));
  PoseCaptures captures = capture_poses(flags.folder, poses, flags.excluded, board, settings,
                                        [&](const std::string& words) {
                                          if (!words.empty()) output.say("{}", words);
                                          progress.advance();
                                        });
  for (const std::string& warning : captures.warnings) output.warn(warning);
  return captures;
}

}  // namespace slipstream::app
