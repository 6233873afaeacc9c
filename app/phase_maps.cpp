#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/process.h"
#include "app/scan_flags.h"
#include "base/numbers.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/plot.h"
#include "slipstream/spatial_unwrapping.h"

namespace slipstream::app {
namespace {

struct UnwrapFlags {
  std::string input, output, method = "flow";
  std::optional<std::string> quality, mask, coarse, regions, preview;
  std::vector<double> anchor;  ///< row, column, phase
};

void apply_mask(Image<double>& phase, const Image<double>& mask) {
  throw_if(mask.size() != phase.size(), "the mask is {}, but the phase map is {}",
           text_of(mask.size()), text_of(phase.size()));

  for (std::size_t i = 0; i < phase.pixel_count(); ++i) {
    const double in = mask.begin()[i];
    if (in == 0 || std::isnan(in)) phase.begin()[i] = nan;
  }
}

void anchor(const UnwrapFlags& flags, UnwrappedPhase<double>& unwrapped) {
  // By a pixel of known phase, or by a coarse map of absolute phase.
  if (!flags.anchor.empty()) {
    const double row = flags.anchor[0], column = flags.anchor[1];
    for (const double place : {row, column}) {
      throw_if(std::rint(place) != place || std::abs(place) > 1e6,
               "--anchor: expected row and column (integers) and a phase");
    }
    anchor_at(unwrapped, static_cast<int>(column), static_cast<int>(row), flags.anchor[2]);
  }

  if (flags.coarse) anchor_by(unwrapped, read_map(*flags.coarse));
}

void tell(const UnwrappedPhase<double>& unwrapped, Output& output) {
  std::size_t pixels = 0, anchored = 0;
  for (const PhaseRegion& region : unwrapped.regions) {
    pixels += region.pixels;
    anchored += region.anchored ? 1 : 0;
    output.add_to("regions", "pixels", region.pixels, "anchored", region.anchored);
  }

  output.document["pixels"] = pixels;
  const std::size_t count = unwrapped.regions.size();
  output.say("{} pixels in {}{}; {} anchored", pixels, counted(count, "region"),
             count > 1 ? fmt::format(", the largest of {}", unwrapped.regions.front().pixels) : "",
             anchored);
}

void unwrap(const UnwrapFlags& flags, Output& output) {
  // 1. Refuse bad names before seconds of work.
  require_map_ending(flags.output);
  if (flags.regions) require_map_ending(*flags.regions);
  if (flags.preview) require_ending(*flags.preview, "preview", {".png"});

  // 2. Read the wrapped phase, without the pixels of the mask; quality steers the path.
  Image<double> phase = read_map(flags.input);
  if (flags.mask) apply_mask(phase, read_levels(*flags.mask));
  Image<float> quality;
  if (flags.quality) quality = converted<float>(read_levels(*flags.quality));

  // 3. Unwrap.
  Stopwatch watch;
  UnwrappedPhase<double> unwrapped = unwrap_in_space(phase, quality, flags.method);
  output.document["seconds"] = watch.lap();

  // 4. Anchor the regions: each is known only up to a multiple of 2 pi.
  anchor(flags, unwrapped);
  output.document["method"] = flags.method;
  tell(unwrapped, output);

  write_map(flags.output, unwrapped.phase);
  if (flags.regions) write_map(*flags.regions, converted<float>(unwrapped.region));
  if (flags.preview) write_map_preview(*flags.preview, unwrapped.phase, "phase, rad");
}

std::string methods() {
  std::string text;
  for (const SpatialUnwrapping& method : spatial_unwrappings()) {
    text += fmt::format("\n  {:14} {}", method.name, method.text);
  }
  return text;
}

struct CalibrateHeightFlags {
  std::vector<std::string> planes;
  std::string heights, output;
  ScanChanges changes;
  ScanJobSettings job;
};

struct HeightFlags {
  std::string scan, calibration, output, preview;
  ScanChanges changes;
  ScanJobSettings job;
};

void add_phase_flags(CLI::App& command, ScanChanges& changes, ScanJobSettings& job) {
  job.output = ScanOutput::maps;
  add_anyway_flag(command, job.keep_refused);
  FlagGroup{command}.add("--minimum-modulation", job.reconstruct.minimum_modulation,
                         "minimum modulation of a valid pixel, grey levels of 255");
  add_scan_input_flags(command, changes, job);
}

/// A scan's projector coordinate, NaN where invalid; a phase map unchanged.
Image<double> measured_phase(const std::string& path, const ScanChanges& changes,
                             const ScanJobSettings& settings, Output& output) {
  const std::string ending = lower_case_extension(path);
  if (ending == ".npy" || ending == ".tiff" || ending == ".tif") return read_map(path);

  const CheckedJob job =
      checked_scan(load_checkable(path, changes, false, output), path, settings, output);
  Engine engine(job.setup);
  return measured_coordinates(engine, job.scan.frames);
}

void calibrate_height(const CalibrateHeightFlags& flags, Output& output) {
  require_ending(flags.output, "calibration of heights", {".npy"});
  const std::vector<double> known = numbers_in<double>(flags.heights, ',');
  throw_if(known.size() != flags.planes.size(),
           "--heights '{}': expected one number for each of {} planes, e.g. 0,10,20", flags.heights,
           flags.planes.size());

  // The phase of each plane at its known height.
  std::vector<PlanePhase> planes;
  Progress progress("planes", known.size());
  for (std::size_t i = 0; i < known.size(); ++i) {
    planes.push_back({known[i], measured_phase(flags.planes[i], flags.changes, flags.job, output)});
    progress.advance();
  }
  progress.finish();

  // Each pixel's curve of height over phase.
  const HeightFit fit = fit_heights(planes);
  for (std::size_t i = 0; i < known.size(); ++i) {
    output.say("{}: {} mm, RMS error {:.4f} mm", flags.planes[i], known[i], fit.rms[i]);
    output.add_to("planes", "plane", flags.planes[i], "rms_mm", fit.rms[i]);
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
  const Image<double> phase = measured_phase(flags.scan, flags.changes, flags.job, output);

  const Image<float> found = heights(curves, phase);
  const std::size_t measured = finite_values(phase).size();
  const std::size_t pixels = finite_values(found).size();

  output.document = described("measured", measured, "pixels", pixels);
  output.say("{} of {} measured pixels have a height", pixels, measured);

  // Under half: the calibration hardly covers this object.
  if (2 * pixels < measured) {
    output.warn(fmt::format(
        "{}: most phases are outside the calibrated heights; the patterns or axis differ from the "
        "planes', the rig moved, or the object reaches beyond the planes",
        flags.scan));
  }

  write_map(flags.output, found);
  if (!flags.preview.empty()) {
    write_map_preview(flags.preview, converted<double>(found), "height, mm");
  }
}

}  // namespace

void add_calibrate_height(const Commands& calibrate) {
  const auto [command, flags] = calibrate.add(
      calibrate_height, "height",
      "calibrate heights over a reference plane, from scans of a plane at known heights");

  required(command.add_file(
      "planes", flags.planes,
      "three or more scans of a plane, or maps of its absolute phase: .tiff or .npy"));

  required(command.add("--heights", flags.heights,
                       "height of each plane over the reference, mm, e.g. 0,10,20"));
  required(command.add_output("-o,--output", flags.output, "calibration file: .npy"));

  add_phase_flags(command.app, flags.changes, flags.job);
  command.common({"--heights", "--output", "--strategy", "--steps", "--high", "--low",
                  "--minimum-modulation"});
  command.examples({"calibrate height plane_0 plane_10 plane_20 --heights 0,10,20 -o heights.npy"});
}

void add_height(const Commands& program) {
  const auto [command, flags] =
      program.add(measure_heights, "height",
                  "measure heights over a reference plane, without a calibrated projector");

  required(
      command.add_file("scan", flags.scan, "a scan, or a map of absolute phase: .tiff or .npy"));
  required(command.add_file("--calibration", flags.calibration,
                            "calibration written by slipstream calibrate height: .npy"));
  required(command.add_output("-o,--output", flags.output, "height map, mm: .tiff or .npy"));

  command.add_output("--preview", flags.preview, "coloured height map: .png");
  add_phase_flags(command.app, flags.changes, flags.job);

  command.common({"--calibration", "--output", "--preview", "--strategy", "--steps", "--high",
                  "--low", "--minimum-modulation"});
  command.examples({"height scan --calibration heights.npy -o height.tiff --preview height.png"});
}

void add_unwrap(const Commands& program) {
  const auto [command, flags] =
      program.add(unwrap, "unwrap", "unwrap a phase map of any instrument spatially");

  required(command.add_file("wrapped", flags.input,
                            "wrapped phase, rad, NaN where invalid: .tiff or .npy"));
  required(command.add_output("-o,--output", flags.output, "unwrapped phase, rad: .tiff or .npy"));

  command.add("--method", flags.method, "method, see below");
  command.add_file("--quality", flags.quality, "quality of each pixel, e.g. its modulation");
  command.add_file("--mask", flags.mask, "mask: 0 at pixels to ignore");

  command.add("--anchor", flags.anchor, "row, column and known phase there, rad")->expected(3);
  command.add_file("--coarse", flags.coarse, "absolute phase, accurate within half a period");
  command.exclude("--coarse", {"--anchor"});

  command.add_output("--regions", flags.regions, "region number of each pixel: .tiff or .npy");
  command.add_output("--preview", flags.preview, "coloured phase map: .png");

  command.app.footer(
      "Methods:" + methods() +
      "\nExamples:\n  slipstream unwrap wrapped.tiff -o phase.tiff --preview phase.png\n"
      "  slipstream unwrap wrapped.npy -o phase.npy --method quality --anchor 240 320 12.5\n"
      "Regions that pixels without a phase keep apart are unwrapped each by itself. A step of half "
      "a period or more between neighbours cannot be known from one map.");
}

}  // namespace slipstream::app
