#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/scan_flags.h"
#include "base/statistics.h"
#include "decode/equations.h"
#include "frames/colour_channels.h"
#include "io/image_file.h"
#include "io/pattern_pictures.h"
#include "io/plot.h"
#include "io/scan_colour.h"
#include "io/scan_pictures.h"
#include "response/ambient_calibration.h"
#include "response/gamma_calibration.h"
#include "response/noise_calibration.h"
#include "response/response_fit.h"
#include "response/scan_average.h"
#include "slipstream/scan_files.h"

namespace slipstream::app {
namespace {

/// Output of a calibration: `-o`, added to the scanner file of `--scanner` or of the first scan.
struct CalibrationFiles {
  std::optional<fs::path> scanner;
  std::string output;
};

void add_calibration_files(CLI::App& command, CalibrationFiles& files) {
  const FlagGroup group{command};
  group.add_file("--scanner", files.scanner, "scanner file to add to; default: the scan's own");
  group.add_output("-o,--output", files.output, "the scanner file to write: .yaml or .xml",
                   scanner_output_type);
}

/// Calls `take` with the frames and sequence of each folder, from scan.yaml and the flags. Prints
/// warnings; throws Error if the check fails. If `files` names no scanner, the result is added to
/// the first scan's. `of_gamma`: the scans measure the response, so a response that shows is not a
/// warning.
void for_each_scan(const std::vector<std::string>& folders, const ScanChanges& changes,
                   CalibrationFiles& files, bool of_gamma, Output& output,
                   const std::function<void(const Scan& scan, const std::string& folder)>& take) {
  Progress progress("scans", folders.size());

  for (const std::string& folder : folders) {
    ScanFiles described = scan_files_in(folder, changes);
    if (files.scanner) described.scanner = files.scanner;
    Scan scan = load_frames(described);
    output.warn(scan.warnings);

    CheckedScan checked = check_and_repair(scan);
    if (of_gamma) checked.findings = without_cause(std::move(checked.findings), CauseKind::gamma);
    refuse_or_warn(checked, folder, false, output);

    // The scan's own scanner file is the one to add to, unless --scanner names another.
    if (!files.scanner) files.scanner = described.scanner;
    try {
      take(scan, folder);
    } catch (const Error& error) {
      const std::string message = error.what();
      throw Error(message.starts_with(folder) ? message : fmt::format("{}: {}", folder, message));
    }

    progress.advance();
  }
}

/// Writes the result to the requested file and prints its path.
void write_calibration(const CalibrationFiles& files, const PhotometricCalibration& found,
                       Output& output) {
  require_valid(found);
  const auto& [from, to] = files;
  if (to.empty()) {
    return output.say("nothing was written; -o scanner.yaml adds the result to a scanner file");
  }

  write_photometric_calibration(from, to, found);
  output.document["output"] = to;
  output.say("{}: written{}", to,
             from ? fmt::format(", with all that {} holds", from->string()) : "");
}

/// Draws a histogram of the values if a file is named.
void write_histogram(const std::string& file, const std::string& title, const std::string& unit,
                     const Histogram& counted, Output& output) {
  if (file.empty()) return;
  const auto& [low, high, counts] = counted;
  write_plot(file, BarPlot{title, unit, "pixels", low, high, {counts.begin(), counts.end()}});
  output.document["histogram"] = file;
}

struct CalibrateAmbientFlags {
  std::vector<std::string> folders;
  ScanChanges scan;
  double least_alpha = 0.5;
  std::string histogram;
  CalibrationFiles files;
};

void calibrate_ambient(const CalibrateAmbientFlags& flags, Output& output) {
  CalibrationFiles files = flags.files;
  ScanAverage scans;
  for_each_scan(flags.folders, flags.scan, files, false, output,
                [&](const Scan& scan, const std::string& folder) {
                  require_ambient_measurable(scan, folder);
                  scans.add(scan, folder);
                });

  // The response counts as linear unless the scanner file holds a measured one.
  std::optional<Response> response;
  if (files.scanner && fs::exists(*files.scanner)) {
    const auto measured = read_photometric_calibration(*files.scanner).response;
    if (measured) response = measured->response;
  }

  const auto& [estimate, counted, least_alpha] =
      slipstream::calibrate_ambient(scans, flags.least_alpha, response);
  if (response) output.say("using the response in {}", files.scanner->string());

  output.say(
      "ambient light {:.3f} grey levels (mode); median {:.3f}, mean {:.3f}, variance {:.3g}, over "
      "{} pixels with alpha of at least {}",
      estimate.mode, estimate.median, estimate.mean, estimate.variance, estimate.pixels,
      flags.least_alpha);
  output.say(
      "with beta_p = {} frames stay above zero for alpha above {:.4g}; for alpha of 0.15 or more "
      "beta_p must be above {:.4g}",
      scans.sequence.light.beta_p, least_alpha, least_beta_p(0.15, estimate.mode));

  output.document = described("ambient", estimate.mode, "median", estimate.median, "mean",
                              estimate.mean, "variance", estimate.variance, "pixels",
                              estimate.pixels, "least_reliable_alpha", least_alpha);

  write_histogram(flags.histogram, "Ambient light of the pixels", "grey levels", counted, output);
  write_calibration(files, {.ambient = estimate.mode}, output);
}

struct CalibrateColourFlags {
  std::string folder;
  ScanChanges scan;
  CalibrationFiles files;
};

/// The picture of that name with any extension.
fs::path picture_named(const fs::path& folder, const std::string& name) {
  for (const fs::path& picture : images_in_folder(folder)) {
    if (picture.stem() == name) return picture;
  }

  throw Error(fmt::format("{}: no picture named {}; expected {} of a white surface",
                          folder.string(), name, fmt::join(primary_names, ", ")));
}

/// The white balance by a grey patch of a scan.
void calibrate_white(const CalibrateColourFlags& flags, Output& output) {
  const WhiteBalance balance = white_balance_of(scan_files_in(flags.folder, flags.scan));
  output.say("white balance: red {:.4f}, green {:.4f}, blue {:.4f}", balance[0], balance[1],
             balance[2]);

  output.document["white_balance"] = balance;
  write_calibration(flags.files, {.white_balance = balance}, output);
}

void calibrate_colour(const CalibrateColourFlags& flags, Output& output) {
  if (flags.scan.grey_patch) return calibrate_white(flags, output);

  std::vector<fs::path> pictures;
  for (const char* name : primary_names) pictures.push_back(picture_named(flags.folder, name));

  const ColourMixture mixture = measured_mixture(read_colour_frames(pictures));

  // Each camera channel: its share of the projected primaries, and its dark level.
  for (std::size_t c = 0; c < mixture.size(); ++c) {
    const auto& [red, green, blue, dark] = mixture[c];
    output.say("the camera's {} sees {:.3f} of red, {:.3f} of green, {:.3f} of blue; dark {:.1f}",
               primary_names[c + 1], red, green, blue, dark);
  }

  output.document["colour_mixture"] = mixture;
  write_calibration(flags.files, {.colour_mixture = mixture}, output);
}

struct CalibrateGammaFlags {
  std::vector<std::string> folders;
  ScanChanges scan;
  std::optional<std::string> uniform;
  bool response = false;
  CalibrationFiles files;
  std::string map;
  std::string histogram;
  double minimum_modulation = 0;
};

void require_pixel_gamma(const CalibrateGammaFlags& flags, bool is_possible,
                         const std::string& why) {
  const bool map = !flags.map.empty();
  throw_if(!is_possible && (map || !flags.histogram.empty()), "{} {}: {}",
           map ? "--map" : "--histogram", map ? flags.map : flags.histogram, why);
}

void tell_pixels(const CalibrateGammaFlags& flags, const PixelGamma& pixels, Output& output) {
  const auto& [map, estimate, counted] = pixels;
  output.say(
      "gamma {:.5f}, standard error {:.2g}: from B_1 and B_2 of {} pixels, with a spread of {:.3g}",
      estimate.gamma, estimate.standard_error, estimate.pixels, estimate.spread);

  output.document["pixels"] =
      described("gamma", estimate.gamma, "standard_error", estimate.standard_error, "spread",
                estimate.spread, "pixels", estimate.pixels, "histogram",
                described("low", counted.low, "high", counted.high, "counts", counted.counts));

  if (!flags.map.empty()) {
    write_map(flags.map, map);
    output.document["map"] = flags.map;
  }

  write_histogram(flags.histogram, "Gamma of every pixel", "gamma", counted, output);
}

struct NamedMeasurement {
  std::string name;
  MeasuredResponse measured;
};

/// nullopt if it takes uniform patterns instead.
std::optional<NamedMeasurement> from_scans(const CalibrateGammaFlags& flags,
                                           const ScanAverage& scans, Output& output) {
  const GammaCalibration found = calibrate_gamma(scans, flags.minimum_modulation);
  const BlindGamma& fit = found.fit;

  output.say("gamma {:.5f}, standard error {:.2g}: fitted to {} pixels with all harmonics",
             fit.gamma, fit.standard_error, fit.pixels);

  output.document["fit"] =
      described("gamma", fit.gamma, "standard_error", fit.standard_error, "pixels", fit.pixels);

  // Gamma per pixel takes the second harmonic, which needs five steps or more.
  require_pixel_gamma(
      flags, found.pixels.has_value(),
      fmt::format("{} steps are too few to measure gamma per pixel; use 5 or more", found.steps));
  if (found.pixels) tell_pixels(flags, *found.pixels, output);

  if (!found.response && flags.uniform) return std::nullopt;
  const MeasuredResponse measured = found_response(found);
  return NamedMeasurement{found.response->name, measured};
}

/// The simplest response that fits uniform patterns, or the measured curve itself if requested.
NamedMeasurement from_uniform(const CalibrateGammaFlags& flags, Output& output) {
  const UniformLevels levels = read_uniform_pictures(*flags.uniform);
  const GammaFit fit = fit_gamma(levels.values, levels.intensities);
  output.say(
      "gamma {:.5f}: curve through {} uniform patterns, RMS residual {:.3g} grey levels; ambient "
      "light {:.3g} grey levels",
      fit.gamma, levels.values.size(), fit.rms, fit.offset);

  output.document["uniform"] =
      described("gamma", fit.gamma, "rms", fit.rms, "offset", fit.offset, "scale", fit.scale);

  // --response keeps the curve as measured; otherwise the simplest formula that fits.
  const auto [name, response] =
      flags.response
          ? NamedResponse{"measured curve", response_curve(levels.values, levels.intensities)}
          : simplest_response(levels.values, levels.intensities);

  return {name, {response, fit.gamma, 0}};
}

void calibrate_gamma(const CalibrateGammaFlags& flags, Output& output) {
  throw_if(flags.folders.empty() && !flags.uniform,
           "calibrate gamma: give folders of scans, or uniform patterns with --uniform");
  throw_if(flags.response && !flags.uniform,
           "--response needs pictures of uniform patterns; name their folder with --uniform");
  require_pixel_gamma(flags, !flags.folders.empty(),
                      "uniform patterns give no per-pixel gamma; give folders of scans");

  CalibrationFiles files = flags.files;

  // 1. Scans of any surface: gamma from the harmonics of the wrapped phase.
  std::optional<NamedMeasurement> found;
  if (!flags.folders.empty()) {
    ScanAverage scans;
    for_each_scan(flags.folders, flags.scan, files, true, output,
                  [&](const Scan& scan, const std::string& folder) { scans.add(scan, folder); });
    found = from_scans(flags, scans, output);
  }

  // 2. Uniform patterns: gamma from the curve. Scans take precedence; --response takes the curve.
  if (flags.uniform) {
    const NamedMeasurement uniform = from_uniform(flags, output);
    if (!found) found = uniform;
    if (flags.response) {
      found->name = uniform.name;
      found->measured.response = uniform.measured.response;
    }
  }

  output.say("response: {}", found->name);
  output.add("response", found->name, "gamma", found->measured.gamma, "standard_error",
             found->measured.standard_error);

  write_calibration(files, {.response = found->measured}, output);
}

struct CalibrateNoiseFlags {
  std::vector<std::string> folders;
  ScanChanges scan;
  CalibrationFiles files;
};

void calibrate_noise(const CalibrateNoiseFlags& flags, Output& output) {
  CalibrationFiles files = flags.files;
  std::vector<NoiseScan> scans;
  for_each_scan(flags.folders, flags.scan, files, false, output,
                [&](const Scan& scan, const std::string&) { scans.emplace_back(scan); });
  const std::vector<NoiseMeasurement> all = slipstream::calibrate_noise(scans);

  for (const NoiseMeasurement& measured : all) {
    output.say("sigma_w^2 {:.4f}, standard error {:.2g}: Eq. ({}), {}, {} times{}{}",
               measured.variance, measured.standard_error, measured.equation, measured.method,
               measured.count, measured.reason.empty() ? "" : "; ", measured.reason);
    output.add_to("measurements", "equation", measured.equation, "variance", measured.variance,
                  "standard_error", measured.standard_error, "count", measured.count, "pixels",
                  measured.pixels, "agrees", measured.reason.empty(), "reason", measured.reason);
  }

  // The list begins with the most trusted measurement.
  const NoiseMeasurement& trusted = all.front();
  if (mistakes_gamma_for_noise(trusted)) {
    output.warn(
        fmt::format("Eq. ({}) alone counts a nonlinear response as noise; give two identical scans "
                    "to separate them",
                    trusted.equation));
  }

  // With pairs of equal scans the variance is a line over the grey level: shot noise.
  const NoiseLine line = noise_line(scans).value_or(NoiseLine{.at_half = trusted.variance});
  if (line.gain > 0) {
    output.say(
        "it grows by {:.4f} per grey level, standard error {:.2g}: {:.4f} at half of full scale",
        line.gain, line.gain_error, line.at_half);
  }

  output.add("noise_variance", line.at_half, "noise_gain", line.gain);
  throw_if(!files.output.empty() && trusted.variance <= 0,
           "the scans contain no noise; nothing was written");

  if (trusted.variance > 0) {
    write_calibration(files, {.noise_variance = line.at_half, .noise_gain = line.gain}, output);
  }
}

}  // namespace

void add_calibrate_ambient(const Commands& calibrate) {
  const auto [command, flags] =
      calibrate.add(calibrate_ambient, "ambient",
                    "measure ambient light from scans of a bright surface with many steps");
  required(command.add_file("folders", flags.folders,
                            "pmp scan folders or recordings of one static scene; averaged"));

  command.add("--least-reflectivity", flags.least_alpha,
              "minimum reflectivity of the pixels used, 0 to 1");

  command.add_output("--histogram", flags.histogram,
                     "histogram of the pixels' ambient light: .png");

  add_calibration_files(command.app, flags.files);
  add_scan_flags(command.app, flags.scan);

  command.common({"--output", "--scanner", "--least-reflectivity", "--steps"});
  command.examples({"calibrate ambient scan_1 scan_2 -o scanner.yaml"});
}

void add_calibrate_colour(const Commands& calibrate) {
  const auto [command, flags] = calibrate.add(
      calibrate_colour, "colour",
      "measure colour crosstalk between projector and camera, from pictures of a white surface, or "
      "the white balance of a colour camera, from a scan with a grey patch");

  required(command.add_file("folder", flags.folder,
                            "folder with a picture of each projected colour, named black, red, "
                            "green and blue (see patterns --colour); with --grey-patch: a scan"));

  add_grey_patch_flag(command, flags.scan);
  add_calibration_files(command.app, flags.files);
  add_scan_flags(command.app, flags.scan);
  command.common({"--output", "--scanner", "--grey-patch"});
  command.examples({"calibrate colour white --scanner scanner.yaml -o scanner.yaml",
                    "calibrate colour scan --grey-patch 20x20+300+200 -o scanner.yaml"});
}

void add_calibrate_gamma(const Commands& calibrate) {
  const auto [command, flags] = calibrate.add(
      calibrate_gamma, "gamma",
      "measure the projector's response from scans of any surface or from uniform patterns");

  command.add_file(
      "folders", flags.folders,
      "scan folders or recordings of one static scene, best with 8 steps or more; averaged");
  command.add("--uniform", flags.uniform,
              "folder of pictures of uniform patterns, named by grey level, e.g. level_017.png");
  command.add("--response", flags.response,
              "store the curve through the uniform patterns instead of a fitted formula");

  add_calibration_files(command.app, flags.files);
  command.add_output("--map", flags.map, "map of each pixel's gamma: .tiff");
  command.add_output("--histogram", flags.histogram, "histogram of the pixels' gamma: .png");

  command
      .add("--minimum-modulation", flags.minimum_modulation,
           "minimum modulation, grey levels of 255")
      ->default_str("16");

  add_scan_flags(command.app, flags.scan);
  command.common(
      {"--output", "--scanner", "--uniform", "--response", "--map", "--strategy", "--steps"});
  command.examples(
      {"calibrate gamma scan_1 scan_2 scan_3 -o scanner.yaml",
       "calibrate gamma --uniform levels --response --scanner scanner.yaml -o scanner.yaml"});
}

void add_calibrate_noise(const Commands& calibrate) {
  const auto [command, flags] = calibrate.add(
      calibrate_noise, "noise", "measure the frames' noise variance in every way the scans allow");

  required(
      command.add_file("folders", flags.folders, "scan folders or recordings of one static scene"));

  add_calibration_files(command.app, flags.files);
  add_scan_flags(command.app, flags.scan);

  command.common({"--output", "--scanner", "--strategy", "--steps", "--high", "--low"});
  command.examples({"calibrate noise scan_1 scan_2 scan_3 -o scanner.yaml"});
}

}  // namespace slipstream::app
