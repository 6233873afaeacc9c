#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/calibration_files.h"
#include "app/commands.h"
#include "app/scan_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/plot_file.h"
#include "slipstream/io/uniform_pictures.h"
#include "slipstream/response/gamma_calibration.h"

namespace slipstream::app {
namespace {

struct CalibrateGammaFlags {
  std::vector<std::string> folders;
  ScanFlags scan;
  std::optional<std::string> uniform;
  bool response = false;
  CalibrationFiles files;
  std::string map;
  std::string histogram;
  double minimum_modulation = 0;
};

void require_pixels_asked_for_can_be(const CalibrateGammaFlags& flags, bool can,
                                     const std::string& why) {
  if (can || (flags.map.empty() && flags.histogram.empty())) return;
  throw Error(fmt::format("{} {}: {}", flags.map.empty() ? "--histogram" : "--map",
                          flags.map.empty() ? flags.histogram : flags.map, why));
}

void tell_pixels(const CalibrateGammaFlags& flags, const PixelGamma& pixels, Output& output) {
  const auto& [map, estimate, counted] = pixels;
  output.say(
      "gamma {:.5f}, standard error {:.2g}: from B_1 and B_2 of each of {} pixels, which spread "
      "by {:.3g}",
      estimate.gamma, estimate.standard_error, estimate.pixels, estimate.spread);
  output.document["pixels"] = {
      {"gamma", estimate.gamma},
      {"standard_error", estimate.standard_error},
      {"spread", estimate.spread},
      {"pixels", estimate.pixels},
      {"histogram", {{"low", counted.low}, {"high", counted.high}, {"counts", counted.counts}}}};
  if (!flags.map.empty()) {
    write_map(flags.map, map);
    output.document["map"] = flags.map;
  }
  if (!flags.histogram.empty()) {
    write_plot(flags.histogram, bar_plot("Gamma of every pixel", "gamma", counted));
    output.document["histogram"] = flags.histogram;
  }
}

struct Found {
  std::string name;
  MeasuredResponse measured;
};

/// Nothing where they do not tell, but uniform patterns will.
std::optional<Found> from_scans(const CalibrateGammaFlags& flags, const ScanAverage& scans,
                                Output& output) {
  const GammaCalibration found = calibrate_gamma(scans, flags.minimum_modulation);
  const BlindGamma& fit = found.fit;
  output.say("gamma {:.5f}, standard error {:.2g}: fitted to {} pixels with all harmonics",
             fit.gamma, fit.standard_error, fit.pixels);
  output.document["fit"] = {
      {"gamma", fit.gamma}, {"standard_error", fit.standard_error}, {"pixels", fit.pixels}};
  require_pixels_asked_for_can_be(
      flags, found.pixels.has_value(),
      fmt::format("{} steps give no gamma for each pixel; it takes 5", found.steps));
  if (found.pixels) tell_pixels(flags, *found.pixels, output);
  if (!found.response && flags.uniform) return std::nullopt;
  const MeasuredResponse measured = found_response(found);
  return Found{found.response->name, measured};
}

/// The simplest response that fits uniform patterns, or the curve itself where that is asked for.
Found from_uniform(const CalibrateGammaFlags& flags, Output& output) {
  const UniformLevels levels = read_uniform_pictures(*flags.uniform);
  const GammaFit fit = fit_gamma(levels.values, levels.intensities);
  output.say(
      "gamma {:.5f}: curve through {} uniform patterns, which it misses by {:.3g} grey "
      "levels RMS; ambient light {:.3g} grey levels",
      fit.gamma, levels.values.size(), fit.rms, fit.offset);
  output.document["uniform"] = {
      {"gamma", fit.gamma}, {"rms", fit.rms}, {"offset", fit.offset}, {"scale", fit.scale}};
  const auto [name, response] =
      flags.response
          ? NamedResponse{"measured curve", response_curve(levels.values, levels.intensities)}
          : simplest_response(levels.values, levels.intensities);
  return {name, {response, fit.gamma, 0}};
}

void calibrate_gamma(const CalibrateGammaFlags& flags, Output& output) {
  if (flags.folders.empty() && !flags.uniform) {
    throw Error("calibrate gamma: give folders of scans, or uniform patterns with --uniform");
  }
  if (flags.response && !flags.uniform) {
    throw Error("--response needs pictures of uniform patterns; name their folder with --uniform");
  }
  require_pixels_asked_for_can_be(
      flags, !flags.folders.empty(),
      "uniform patterns give no gamma for each pixel; give folders of scans");
  CalibrationFiles files = flags.files;
  std::optional<Found> found;
  if (!flags.folders.empty()) {
    ScanAverage scans;
    for_each_scan(flags.folders, flags.scan, files, true, output,
                  [&](const Scan& scan, const std::string& folder) { scans.add(scan, folder); });
    found = from_scans(flags, scans, output);
  }
  if (flags.uniform) {
    const Found uniform = from_uniform(flags, output);
    if (!found) found = uniform;
    if (flags.response) {
      found->name = uniform.name;
      found->measured.response = uniform.measured.response;
    }
  }
  output.say("response: {}", found->name);
  output.document["response"] = found->name;
  output.document["gamma"] = found->measured.gamma;
  output.document["standard_error"] = found->measured.standard_error;
  write_calibration(files, {.response = found->measured}, output);
}

}  // namespace

void add_calibrate_gamma(CLI::App& calibrate, Command& chosen) {
  const auto [command, flags] =
      add_command(calibrate, chosen, calibrate_gamma, "gamma",
                  "the projector's response, from scans of any surface or uniform patterns");
  command.add_file(
      "folders", flags.folders,
      "scan folders or recordings of one unmoved scene, best of 8 steps or more; averaged");
  command.add("--uniform", flags.uniform,
              "folder of pictures of uniform patterns, named by grey level: level_017.png");
  command.add("--response", flags.response,
              "take the curve through the uniform patterns, whatever its form");
  add_calibration_files(command.app, flags.files);
  command.add_output("--map", flags.map, "gamma of every pixel: .tiff");
  command.add_output("--histogram", flags.histogram, "gamma of the pixels, counted: .png");
  command.add("--min-modulation", flags.minimum_modulation, "least modulation, grey levels of 255")
      ->default_str("16");
  add_scan_flags(command.app, flags.scan);
  command.app.footer(
      "Examples:\n  slipstream calibrate gamma scan_1 scan_2 scan_3 -o scanner.yaml\n  slipstream "
      "calibrate gamma --uniform levels --response --scanner scanner.yaml -o scanner.yaml");
}

}  // namespace slipstream::app
