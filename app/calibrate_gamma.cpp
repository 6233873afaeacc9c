#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "app/calibrate.h"
#include "app/calibration_scans.h"
#include "app/progress.h"
#include "app/scan_flags.h"
#include "slipstream/capture/mean_frames.h"
#include "slipstream/error/error.h"
#include "slipstream/gamma/blind.h"
#include "slipstream/gamma/measurement.h"
#include "slipstream/gamma/response.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/plot_file.h"
#include "slipstream/io/response_file.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct CalibrateGammaFlags {
  std::vector<std::string> folders;
  ScanFlags scan;
  std::optional<std::string> uniform;
  bool response = false;
  std::optional<std::string> scanner;
  std::string output;
  std::string map;
  std::string histogram;
  double minimum_modulation = 0;
};

/// Scans of one scene, averaged, with what their first scan.yaml says.
struct AveragedScans {
  ScanDescription scan;
  MeanFrames frames;
};

AveragedScans averaged_scans(const CalibrateGammaFlags& flags, Output& output) {
  AveragedScans scans;
  Progress progress("scans", static_cast<int>(flags.folders.size()));
  for (const std::string& folder : flags.folders) {
    ScanDescription scan = describe_scan(folder, flags.scan);
    const LoadedFrames loaded = read_frames(scan.frames, scan.bits);
    for (const std::string& warning : loaded.warnings) output.warn(warning);
    if (scans.frames.count() == 0) {
      scans.scan = std::move(scan);
    } else if (settings_of(scan.strategy) != settings_of(scans.scan.strategy)) {
      throw Error(fmt::format("{}: another strategy than in {}; scans that are averaged are alike",
                              folder, flags.folders.front()));
    }
    scans.frames.add(loaded.frames);
    progress.advance();
  }
  return scans;
}

/// What the scans say of gamma, and what to write.
struct ScanGamma {
  double gamma = 1;
  double standard_error = 0;
};

void write_pixel_files(const CalibrateGammaFlags& flags, const Image<double>& map,
                       const Histogram& counted, Output& output) {
  if (!flags.map.empty()) {
    write_map(flags.map, map);
    output.document["map"] = flags.map;
  }
  if (!flags.histogram.empty()) {
    write_plot(flags.histogram, BarPlot{"Gamma of every pixel",
                                        "gamma",
                                        "pixels",
                                        counted.low,
                                        counted.high,
                                        {counted.counts.begin(), counted.counts.end()}});
    output.document["histogram"] = flags.histogram;
  }
}

ScanGamma from_scans(const CalibrateGammaFlags& flags, const AveragedScans& scans, Output& output) {
  const int steps = step_counts(scans.scan.strategy).front();
  const FrameSet frames = scans.frames.mean();
  const auto pixels = pixel_harmonics(frames, 0, steps);
  Image<std::uint8_t> lit = well_lit(pixels, frames, flags.minimum_modulation);
  std::transform(lit.begin(), lit.end(), scans.frames.saturated().begin(), lit.begin(),
                 [](std::uint8_t is_lit, std::uint8_t saturated) {
                   return static_cast<std::uint8_t>(is_lit != 0 && saturated == 0 ? 1 : 0);
                 });
  const BlindGamma fit = find_gamma(pixels, lit, steps);
  if (fit.refusal == BlindRefusal::too_few_pixels) {
    throw Error(fmt::format("{}: {}; show the patterns brighter or expose longer",
                            flags.folders.front(), reason_of(fit.refusal)));
  }
  output.say("gamma {:.5f}, standard error {:.2g}: fitted to {} pixels with all harmonics",
             fit.gamma, fit.standard_error, fit.pixels);
  output.document["fit"] = {
      {"gamma", fit.gamma}, {"standard_error", fit.standard_error}, {"pixels", fit.pixels}};
  if (steps >= 5) {
    const Image<double> map = gamma_map(pixels, lit);
    const GammaEstimate estimate = robust_gamma(map);
    output.say(
        "gamma {:.5f}, standard error {:.2g}: from B_1 and B_2 of each of {} pixels, which spread "
        "by {:.3g}",
        estimate.gamma, estimate.standard_error, estimate.pixels, estimate.spread);
    const double reach = std::max(5 * estimate.spread, 1e-3);
    const Histogram counted = histogram(map, estimate.gamma - reach, estimate.gamma + reach, 50);
    output.document["pixels"] = {
        {"gamma", estimate.gamma},
        {"standard_error", estimate.standard_error},
        {"spread", estimate.spread},
        {"pixels", estimate.pixels},
        {"histogram", {{"low", counted.low}, {"high", counted.high}, {"counts", counted.counts}}}};
    write_pixel_files(flags, map, counted, output);
  } else if (!flags.map.empty() || !flags.histogram.empty()) {
    throw Error(fmt::format("{} {}: {} steps give no gamma for each pixel; it takes 5",
                            flags.map.empty() ? "--histogram" : "--map",
                            flags.map.empty() ? flags.histogram : flags.map, steps));
  }
  if (!fit.accepted() && fit.refusal != BlindRefusal::no_distortion) {
    throw Error(
        fmt::format("{}: {}; scan with at least 5 steps, or measure the response with "
                    "--uniform and --response",
                    flags.folders.front(), reason_of(fit.refusal)));
  }
  return {fit.gamma, fit.standard_error};
}

/// The grey level in a picture's name: 17 in level_017.png.
double level_in(const fs::path& picture) {
  static constexpr std::string_view prefix = "level_";
  const std::string stem = picture.stem().string();
  const std::string digits = stem.starts_with(prefix) ? stem.substr(prefix.size()) : "";
  const bool number = std::all_of(digits.begin(), digits.end(),
                                  [](unsigned char c) { return std::isdigit(c) != 0; });
  if (digits.empty() || digits.size() > 3 || !number || std::stoi(digits) > 255) {
    throw Error(fmt::format(
        "{}: no grey level in its name; pictures of uniform patterns are named as level_017.png",
        picture.string()));
  }
  return std::stoi(digits) / 255.0;
}

/// What the camera saw of uniform patterns in the middle of its picture, where the light is even.
struct UniformLevels {
  std::vector<double> values;
  std::vector<double> intensities;  ///< grey levels of 255
};

UniformLevels read_uniform(const fs::path& folder, Output& output) {
  UniformLevels levels;
  for (const fs::path& picture : images_in_folder(folder)) {
    const LoadedFrames loaded = read_frames({picture});
    for (const std::string& warning : loaded.warnings) output.warn(warning);
    const Size size = loaded.frames.size();
    std::vector<double> middle;
    loaded.frames.visit([&](const auto& views) {
      for (int row = 3 * size.height / 8; row <= 5 * size.height / 8; ++row) {
        for (int column = 3 * size.width / 8; column <= 5 * size.width / 8; ++column) {
          middle.push_back(static_cast<double>(views[0](column, row)));
        }
      }
    });
    double sum = 0;
    for (const double intensity : middle) sum += intensity;
    const double mean = sum / static_cast<double>(middle.size()) * 255 / loaded.frames.full_scale();
    if (mean > 0.98 * 255) {
      throw Error(fmt::format("{}: saturated; expose shorter", picture.string()));
    }
    levels.values.push_back(level_in(picture));
    levels.intensities.push_back(mean);
  }
  return levels;
}

void calibrate_gamma(const CalibrateGammaFlags& flags, Output& output) {
  if (flags.folders.empty() && !flags.uniform) {
    throw Error("calibrate gamma: give folders of scans, or uniform patterns with --uniform");
  }
  if (flags.response && !flags.uniform) {
    throw Error("--response needs pictures of uniform patterns; name their folder with --uniform");
  }
  if (flags.folders.empty() && !(flags.map.empty() && flags.histogram.empty())) {
    throw Error(
        fmt::format("{} {}: uniform patterns give no gamma for each pixel; give folders of scans",
                    flags.map.empty() ? "--histogram" : "--map",
                    flags.map.empty() ? flags.histogram : flags.map));
  }
  std::optional<fs::path> scanner;
  if (flags.scanner) scanner = *flags.scanner;
  std::optional<ScanGamma> gamma;
  if (!flags.folders.empty()) {
    const AveragedScans scans = averaged_scans(flags, output);
    gamma = from_scans(flags, scans, output);
    if (!scanner) scanner = scans.scan.scanner;
  }
  std::optional<Response> response;
  if (flags.uniform) {
    const UniformLevels levels = read_uniform(*flags.uniform, output);
    const GammaFit fit = fit_gamma(levels.values, levels.intensities);
    output.say(
        "gamma {:.5f}: curve through {} uniform patterns, which it misses by {:.3g} grey "
        "levels RMS; ambient light {:.3g} grey levels",
        fit.gamma, levels.values.size(), fit.rms, fit.offset);
    output.document["uniform"] = {
        {"gamma", fit.gamma}, {"rms", fit.rms}, {"offset", fit.offset}, {"scale", fit.scale}};
    if (flags.response) {
      response = response_curve(levels.values, levels.intensities);
      output.say("the measured curve is the response, {} points", levels.values.size());
    }
    if (!gamma) gamma = ScanGamma{fit.gamma, 0};
  }
  output.document["gamma"] = gamma->gamma;
  output.document["standard_error"] = gamma->standard_error;
  if (!response) {
    require_gamma(gamma->gamma, "gamma");
    response = PowerLaw{gamma->gamma};
  }
  if (flags.output.empty()) {
    output.say("nothing was asked to be written; -o scanner.yaml writes it into a scanner file");
    return;
  }
  write_response(scanner, flags.output, *response, gamma->gamma, gamma->standard_error);
  output.document["output"] = flags.output;
  output.say("{}: written{}", flags.output,
             scanner ? fmt::format(", with all that {} holds", scanner->string()) : "");
}

}  // namespace

void add_calibrate_gamma(CLI::App& calibrate, SharedFlags& shared, Command& chosen) {
  CLI::App* command = calibrate.add_subcommand(
      "gamma", "the projector's response, from scans of any surface or uniform patterns");
  const auto flags = std::make_shared<CalibrateGammaFlags>();
  command->add_option("folders", flags->folders,
                      "scan folders of one unmoved scene, best of 5 steps or more; averaged");
  command->add_option("--uniform", flags->uniform,
                      "folder of pictures of uniform patterns, named by grey level: level_017.png");
  command->add_flag("--response", flags->response,
                    "take the curve through the uniform patterns, whatever its form");
  command->add_option("--scanner", flags->scanner,
                      "scanner file to add to; where not that of scan.yaml");
  command->add_option("-o,--output", flags->output, "the scanner file to write: .yaml or .xml");
  command->add_option("--map", flags->map, "gamma of every pixel: .tiff");
  command->add_option("--histogram", flags->histogram, "gamma of the pixels, counted: .png");
  command->add_option("--min-modulation", flags->minimum_modulation,
                      "least modulation, grey levels of 255; 16 where not given");
  add_scan_flags(*command, flags->scan);
  add_shared_flags(*command, shared);
  command->footer(
      "Examples:\n  slipstream calibrate gamma scan_1 scan_2 scan_3 -o scanner.yaml\n  slipstream "
      "calibrate gamma --uniform levels --response --scanner scanner.yaml -o scanner.yaml");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { calibrate_gamma(*flags, output); }; });
}

}  // namespace slipstream::app
