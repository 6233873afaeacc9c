#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/calibrate.h"
#include "app/calibration_scans.h"
#include "app/progress.h"
#include "slipstream/capture/mean_frames.h"
#include "slipstream/error/error.h"
#include "slipstream/gamma/measurement.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/io/plot_file.h"
#include "slipstream/noise/ambient_measurement.h"
#include "slipstream/noise/reflectivity.h"
#include "slipstream/phase/phase_decoder.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct CalibrateAmbientFlags {
  std::vector<std::string> folders;
  ScanFlags scan;
  double least_alpha = 0.5;
  std::string histogram;
  CalibrationFiles files;
};

struct AmbientScans {
  ScanDescription scan;
  MeanFrames frames;
  Image<std::uint8_t> measured;
};

AmbientScans read_scans(const CalibrateAmbientFlags& flags, Output& output) {
  AmbientScans scans;
  Progress progress("scans", static_cast<int>(flags.folders.size()));
  for (const std::string& folder : flags.folders) {
    const ScanDescription scan = describe_scan(folder, flags.scan);
    if (std::holds_alternative<PhaseChannelMultiplexing>(scan.strategy)) {
      throw Error(
          fmt::format("{}: pcmp; ambient light is measured with pmp or dual-frequency", folder));
    }
    const LoadedFrames loaded = read_frames(scan.frames, scan.bits);
    for (const std::string& warning : loaded.warnings) output.warn(warning);
    const Image<std::uint8_t> good = unclipped(loaded.frames);
    if (scans.frames.count() == 0) {
      scans.scan = scan;
      scans.measured = good;
    } else if (name_of(scan.strategy) != name_of(scans.scan.strategy) ||
               settings_of(scan.strategy) != settings_of(scans.scan.strategy)) {
      throw Error(fmt::format("{}: another strategy than in {}; scans that are averaged are alike",
                              folder, flags.folders.front()));
    }
    scans.frames.add(loaded.frames);
    std::transform(scans.measured.begin(), scans.measured.end(), good.begin(),
                   scans.measured.begin(),
                   [](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a & b); });
    progress.advance();
  }
  return scans;
}

void write_histogram(const std::string& path, const Image<double>& map,
                     const AmbientEstimate& estimate) {
  const double reach = std::max(1.0, 5 * std::sqrt(estimate.variance));
  const Histogram counted = histogram(map, estimate.median - reach, estimate.median + reach, 60);
  write_plot(path, BarPlot{"Ambient light of the pixels",
                           "grey levels",
                           "pixels",
                           counted.low,
                           counted.high,
                           {counted.counts.begin(), counted.counts.end()}});
}

void calibrate_ambient(const CalibrateAmbientFlags& flags, Output& output) {
  if (!(flags.least_alpha > 0 && flags.least_alpha <= 1)) {
    throw Error(fmt::format("--least-reflectivity {} is out of range; above 0, at most 1",
                            flags.least_alpha));
  }
  const AmbientScans scans = read_scans(flags, output);
  const int steps = step_counts(scans.scan.strategy).front();
  const PhaseMaps maps = PhaseDecoder(Backend::equation, {steps})(scans.frames.mean(), 0, steps);
  const PatternLight& light = scans.scan.light;
  const Image<double> map =
      ambient_map(maps.mean, maps.modulation, light, flags.least_alpha, scans.measured);
  const AmbientEstimate estimate = ambient_estimate(map);
  const double least_alpha = least_reliable_reflectivity(light.beta_p, estimate.mode);

  output.say(
      "ambient light {:.3f} grey levels (mode); median {:.3f}, mean {:.3f}, variance {:.3g}, "
      "over {} pixels with alpha of {} and more",
      estimate.mode, estimate.median, estimate.mean, estimate.variance, estimate.pixels,
      flags.least_alpha);
  output.say(
      "with beta_p = {} frames are off zero where alpha is above {:.4g}; for alpha of 0.15 "
      "and more beta_p must be above {:.4g}",
      light.beta_p, least_alpha, least_beta_p(0.15, estimate.mode));
  output.document = {{"ambient", estimate.mode},  {"median", estimate.median},
                     {"mean", estimate.mean},     {"variance", estimate.variance},
                     {"pixels", estimate.pixels}, {"least_reliable_alpha", least_alpha}};
  if (!flags.histogram.empty()) {
    write_histogram(flags.histogram, map, estimate);
    output.document["histogram"] = flags.histogram;
  }
  if (flags.files.output.empty()) {
    output.say("nothing was asked to be written; -o scanner.yaml writes it into a scanner file");
    return;
  }
  std::optional<fs::path> from = scans.scan.scanner;
  if (flags.files.scanner) from = *flags.files.scanner;
  write_photometric_calibration(from, flags.files.output,
                                {.ambient = estimate.mode, .noise_variance = {}});
  output.document["output"] = flags.files.output;
  output.say("{}: written", flags.files.output);
}

}  // namespace

void add_calibrate_ambient(CLI::App& calibrate, SharedFlags& shared, Command& chosen) {
  CLI::App* command = calibrate.add_subcommand(
      "ambient", "the ambient light, from scans of a bright surface with many steps");
  const auto flags = std::make_shared<CalibrateAmbientFlags>();
  command->add_option("folders", flags->folders, "scan folders of one unmoved scene, pmp; averaged")
      ->required();
  command
      ->add_option("--least-reflectivity", flags->least_alpha, "of the pixels that count, 0 to 1")
      ->capture_default_str();
  command->add_option("--histogram", flags->histogram, "of the pixels' ambient light: .png");
  add_calibration_files(*command, flags->files);
  add_scan_flags(*command, flags->scan);
  add_shared_flags(*command, shared);
  command->footer("Example:\n  slipstream calibrate ambient scan_1 scan_2 -o scanner.yaml");
  command->callback([flags, &chosen] {
    chosen = [flags](Output& output) { calibrate_ambient(*flags, output); };
  });
}

}  // namespace slipstream::app
