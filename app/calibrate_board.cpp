#include <cmath>
#include <string>

#include <fmt/format.h>

#include "app/board_flags.h"
#include "app/commands.h"
#include "app/scan_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/io/image_file.h"

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

}  // namespace slipstream::app
