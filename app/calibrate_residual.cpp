#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/scan_flags.h"
#include "base/numbers.h"
#include "io/plot.h"
#include "reconstruct/epipolar_residual.h"
#include "slipstream/scanner_file.h"

namespace slipstream::app {
namespace {

struct CalibrateResidualFlags {
  std::string scan, output;
  std::optional<std::string> picture;
  ScanChanges changes;
  ScanJobSettings job;
};

/// The medians of all blocks before and after the map, side by side, in the same colours.
Image<double> side_by_side(const Image<float>& left, const Image<float>& right) {
  const Size size = left.size();
  Image<double> both({2 * size.width + 1, size.height}, nan);
  for_each_pixel_in_order(size, [&](int column, int row) {
    both(column, row) = left(column, row);
    both(size.width + 1 + column, row) = right(column, row);
  });
  return both;
}

void calibrate_residual(const CalibrateResidualFlags& flags, Output& output) {
  // 1. The scan's distances from the epipolar lines.
  ScanJobSettings settings = flags.job;
  settings.maps = true;
  Scan scan = load_checkable(flags.scan, flags.changes, false, output);
  throw_if(scan.other_axis.empty(), "{}: a residual map requires patterns along both axes",
           flags.scan);
  const ScanResult result = result_of(std::move(scan), flags.scan, settings, output);

  // 2. The map that held-out parts of the picture support.
  const Scanner& scanner = result.setup.scanner;
  const EpipolarResidual found =
      epipolar_residual(scanner, result.cloud, result.maps.epipolar_distance);

  output.document.update(
      described("scanner", flags.output, "degree", found.degree, "blocks", found.blocks));
  for (const EpipolarScore& score : found.scores) {
    const std::string map =
        score.degree > 0 ? fmt::format("a map of degree {}", score.degree) : "no map";
    output.say("{}: held-out blocks off by {:.4f} projector pixels", map, score.deviation);
    output.add_to("maps", "degree", score.degree, "left_out_px", score.deviation);
  }

  // 3. The picture, whose name may be refused, then the scanner file.
  if (flags.picture) {
    write_map_preview(*flags.picture, side_by_side(found.before, found.after), "px");
    output.document["picture"] = *flags.picture;
    output.say("distances of all blocks, before and after: {}", *flags.picture);
  }

  replace_geometry(flags.output, found.scanner);
  output.say("scanner file with the map of degree {}, of {} blocks: {}", found.degree, found.blocks,
             flags.output);
}

}  // namespace

void add_calibrate_residual(const Commands& calibrate) {
  const auto [command, flags] =
      calibrate.add(calibrate_residual, "residual",
                    "map the remainder of a scanner file's lens model, by a scan along both axes");
  required(command.add_file("scan", flags.scan,
                            "scan along both axes of a surface that fills the picture"));
  required(command.add_output("-o,--output", flags.output,
                              "scanner file with a residual map of the camera: .yaml or .xml",
                              scanner_output_type));
  command.add_output("--picture", flags.picture,
                     "distances from the epipolar lines before and after, in projector pixels: "
                     ".png");

  add_scan_input_flags(command.app, flags.changes, flags.job);
  command.common({"--output", "--picture", "--scanner", "--strategy", "--steps", "--high", "--low",
                  "--projector"});
  command.examples(
      {"calibrate residual scan --scanner scanner.yaml -o corrected.yaml --picture "
       "residual.png"});
}

}  // namespace slipstream::app
