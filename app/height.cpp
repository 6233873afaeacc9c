#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/output.h"
#include "app/scan_input.h"
#include "slipstream/base/error.h"
#include "slipstream/base/image.h"
#include "slipstream/base/numbers.h"
#include "slipstream/base/statistics.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/plot.h"
#include "slipstream/reconstruct/picture_report.h"

namespace slipstream::app {
namespace {

struct CalibrateHeightFlags {
  std::vector<std::string> planes;
  std::string heights, output;
  CloudInputFlags phase;
};

struct HeightFlags {
  std::string scan, calibration, output, preview;
  CloudInputFlags phase;
};

void add_phase_flags(CLI::App& command, CloudInputFlags& flags) {
  add_anyway_flag(command, flags.anyway);
  FlagGroup{command}.add("--min-modulation", flags.settings.minimum_modulation,
                         "of a pixel that is measured, grey levels of 255");
  add_scan_input_flags(command, flags.input);
}

/// Of a scan the projector coordinate, NaN where it is not measured; a phase map as it is.
Image<double> measured_phase(const std::string& path, const CloudInputFlags& flags,
                             Output& output) {
  const std::string ending = lower_case_extension(path);
  if (ending == ".npy" || ending == ".tiff" || ending == ".tif") return read_map(path);
  Scan scan = load_checkable(path, flags.input, false, output);
  PhotometricCalibration known = scan.scanner ? scan.scanner->photometry : flags.input.photometry;
  known.response = choose_response(scan, flags.input.gamma).response;
  refuse_or_warn(check_and_repair(scan, {.minimum_modulation = flags.settings.minimum_modulation,
                                         .photometry = known}),
                 path, flags.anyway, output);
  const EngineSetup setup{without_geometry(scan.frames.size(), scan.sequence.projector, known),
                          scan.sequence, flags.settings};
  require_ambient_known(setup, path);
  Engine engine(setup);
  return measured_coordinates(engine, scan.frames);
}

void calibrate_height(const CalibrateHeightFlags& flags, Output& output) {
  require_ending(flags.output, "calibration of heights", {".npy"});
  const std::vector<double> known = numbers_in<double>(flags.heights, ',');
  if (known.size() != flags.planes.size()) {
    throw Error(fmt::format("--heights '{}' is not a number for each of {} planes, as 0,10,20",
                            flags.heights, flags.planes.size()));
  }
  std::vector<PlanePhase> planes;
  Progress progress("planes", static_cast<int>(known.size()));
  for (std::size_t i = 0; i < known.size(); ++i) {
    planes.push_back({known[i], measured_phase(flags.planes[i], flags.phase, output)});
    progress.advance();
  }
  progress.finish();
  const HeightFit fit = fit_heights(planes);
  for (std::size_t i = 0; i < known.size(); ++i) {
    output.say("{}: {} mm, RMS error {:.4f} mm", flags.planes[i], known[i], fit.rms[i]);
    output.list("planes").push_back({{"plane", flags.planes[i]}, {"rms_mm", fit.rms[i]}});
  }
  write_height_curves(flags.output, fit.curves);
  output.say("{}: {} of {} pixels are calibrated", flags.output, fit.pixels,
             fit.curves.pixel_count());
  output.document["pixels"] = fit.pixels;
}

void measure_heights(const HeightFlags& flags, Output& output) {
  require_map_ending(flags.output);
  if (!flags.preview.empty()) require_ending(flags.preview, "preview", {".png"});
  const Image<HeightCurve> curves = read_height_curves(flags.calibration);
  const Image<double> phase = measured_phase(flags.scan, flags.phase, output);
  const Image<float> found = heights(curves, phase);
  const std::size_t measured = finite_values(phase).size();
  const std::size_t pixels = finite_values(found).size();
  output.document = {{"measured", measured}, {"pixels", pixels}};
  output.say("{} of {} measured pixels have a height", pixels, measured);
  if (2 * pixels < measured) {
    output.warn(fmt::format(
        "{}: most of its phases are of no calibrated height; other patterns or another axis than "
        "the planes', a rig that was moved, or a thing beyond the planes",
        flags.scan));
  }
  write_map(flags.output, found);
  if (!flags.preview.empty()) {
    write_map_preview(flags.preview, converted<double>(found), "height, mm");
  }
}

}  // namespace

void add_calibrate_height(CLI::App& calibrate, Command& chosen) {
  const auto [command, flags] =
      add_command(calibrate, chosen, calibrate_height, "height",
                  "heights over a reference plane, from scans of it moved by known heights");
  command
      .add_file("planes", flags.planes,
                "scans of a plane, three or more, or maps of its absolute phase: .tiff or .npy")
      ->required();
  command.add("--heights", flags.heights, "of each plane, mm, the reference at 0: 0,10,20")
      ->required();
  command.add_output("-o,--output", flags.output, "the calibration: .npy")->required();
  add_phase_flags(command.app, flags.phase);
  command.app.footer(
      "Example:\n  slipstream calibrate height plane_0 plane_10 plane_20 --heights 0,10,20 -o "
      "heights.npy");
}

void add_height(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, measure_heights, "height",
                  "a scan to heights over a reference plane, of a rig without a calibrated "
                  "projector");
  command.add_file("scan", flags.scan, "a scan, or a map of its absolute phase: .tiff or .npy")
      ->required();
  command
      .add_file("--calibration", flags.calibration, "what slipstream calibrate height wrote: .npy")
      ->required();
  command.add_output("-o,--output", flags.output, "height of each pixel, mm: .tiff or .npy")
      ->required();
  command.add_output("--preview", flags.preview, "the heights in colours: .png");
  add_phase_flags(command.app, flags.phase);
  command.app.footer(
      "Example:\n  slipstream height scan --calibration heights.npy -o height.tiff --preview "
      "height.png");
}

}  // namespace slipstream::app
