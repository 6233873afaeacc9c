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
#include "slipstream/error/error.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/noise/noise_measurement.h"
#include "slipstream/phase/phase_channel.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct CalibrateNoiseFlags {
  std::vector<std::string> folders;
  ScanFlags scan;
  CalibrationFiles files;
};

/// What the measurements need of one scan: of its first sinusoid, grey levels of 8 bits.
struct NoiseScan {
  ScanDescription scan;
  int steps = 0;
  Image<std::uint8_t> measured;
  Image<double> mean;
  Image<double> b_cos;          ///< N = 4 without a cue in it
  Image<double> modulation[2];  ///< of PCMP, N >= 5
};

/// One of the four measurements, over all scans or pairs of scans that allow it.
struct Measured {
  const char* equation;
  const char* method;
  NoiseEstimate sum;
  int count = 0;

  void add(const NoiseEstimate& estimate) {
    sum.variance += estimate.variance;
    sum.standard_error += estimate.standard_error * estimate.standard_error;
    sum.pixels = estimate.pixels;
    ++count;
  }
  [[nodiscard]] double variance() const { return sum.variance / count; }
  [[nodiscard]] double standard_error() const { return std::sqrt(sum.standard_error) / count; }
};

NoiseScan read_scan(const std::string& folder, const ScanFlags& flags, Output& output) {
  constexpr double least_modulation = 8;
  NoiseScan scan;
  scan.scan = describe_scan(folder, flags);
  const LoadedFrames loaded = read_frames(scan.scan.frames, scan.scan.bits);
  for (const std::string& warning : loaded.warnings) output.warn(warning);
  const FrameSet& frames = loaded.frames;
  const double grey_level = frames.full_scale() / 255;
  const auto in_8_bits = [&](Image<double> image) {
    std::transform(image.begin(), image.end(), image.begin(),
                   [&](double value) { return value / grey_level; });
    return image;
  };
  const int N = scan.steps = step_counts(scan.scan.strategy).front();
  const bool pcmp = std::holds_alternative<PhaseChannelMultiplexing>(scan.scan.strategy);
  scan.mean = in_8_bits(weighted_sum(frames, 0, mean_weights(N)));
  if (N == 4 && !pcmp) scan.b_cos = in_8_bits(weighted_sum(frames, 0, half_phase_weights()));
  const Image<double> modulation = in_8_bits(channel_modulation(frames, N, 1));
  scan.measured = unclipped(frames);
  std::transform(scan.measured.begin(), scan.measured.end(), modulation.begin(),
                 scan.measured.begin(), [](std::uint8_t good, double B) {
                   return static_cast<std::uint8_t>(good != 0 && B >= least_modulation ? 1 : 0);
                 });
  if (N >= 5 && pcmp) {
    scan.modulation[0] = modulation;
    scan.modulation[1] = in_8_bits(channel_modulation(frames, N, 2));
  }
  return scan;
}

bool alike(const NoiseScan& a, const NoiseScan& b) {
  return name_of(a.scan.strategy) == name_of(b.scan.strategy) &&
         settings_of(a.scan.strategy) == settings_of(b.scan.strategy);
}

bool both_pmp(const NoiseScan& a, const NoiseScan& b) {
  return std::holds_alternative<PhaseMeasuring>(a.scan.strategy) &&
         std::holds_alternative<PhaseMeasuring>(b.scan.strategy);
}

Image<std::uint8_t> in_both(const NoiseScan& a, const NoiseScan& b) {
  if (a.mean.size() != b.mean.size()) {
    throw Error("the scans are of different sizes; they are to be of one unmoved scene");
  }
  Image<std::uint8_t> both = a.measured;
  std::transform(both.begin(), both.end(), b.measured.begin(), both.begin(),
                 [](std::uint8_t x, std::uint8_t y) { return static_cast<std::uint8_t>(x & y); });
  return both;
}

/// All that the scans allow, in the order in which they are trusted.
std::vector<Measured> measure(const std::vector<NoiseScan>& scans) {
  Measured halves{"3.82", "half phase channels of two scans", {}, 0};
  Measured means{"3.20", "means of two scans", {}, 0};
  Measured unequal_means{"3.19", "means of two scans of other step counts", {}, 0};
  Measured modulations{"3.99", "two modulations of one pcmp scan", {}, 0};
  Measured half{"3.79", "half phase channel of one scan", {}, 0};
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const NoiseScan& a = scans[i];
    if (!a.b_cos.empty()) half.add(noise_from_half_phase(a.b_cos, a.measured));
    if (!a.modulation[1].empty()) {
      const double c1 = std::get<PhaseChannelMultiplexing>(a.scan.strategy).c1();
      modulations.add(
          noise_from_modulations(a.modulation[0], a.modulation[1], a.steps, c1, a.measured));
    }
    for (std::size_t j = i + 1; j < scans.size(); ++j) {
      const NoiseScan& b = scans[j];
      if (!alike(a, b) && !both_pmp(a, b)) continue;
      const Image<std::uint8_t> both = in_both(a, b);
      (alike(a, b) ? means : unequal_means)
          .add(noise_from_means(a.mean, a.steps, b.mean, b.steps, both));
      if (alike(a, b) && !a.b_cos.empty()) {
        halves.add(noise_from_half_phases(a.b_cos, b.b_cos, both));
      }
    }
  }
  std::vector<Measured> all{halves, means, unequal_means, modulations, half};
  std::erase_if(all, [](const Measured& measured) { return measured.count == 0; });
  return all;
}

/// Why a measurement says another value than the one trusted most; empty where it does not.
std::string disagreement(const Measured& other, const Measured& trusted) {
  const double difference = other.variance() - trusted.variance();
  const double error = std::hypot(other.standard_error(), trusted.standard_error());
  if (std::abs(difference) < std::max(4 * error, 0.05 * trusted.variance())) return "";
  const std::string equation = other.equation;
  if (equation == "3.79" || equation == "3.99" || equation == "3.19") {
    return "the response is not linear, and this counts what it leaves as noise: calibrate gamma";
  }
  return "light or scene changed between the scans in a way that is not the same everywhere";
}

void calibrate_noise(const CalibrateNoiseFlags& flags, Output& output) {
  std::vector<NoiseScan> scans;
  Progress progress("scans", static_cast<int>(flags.folders.size()));
  for (const std::string& folder : flags.folders) {
    scans.push_back(read_scan(folder, flags.scan, output));
    progress.advance();
  }
  progress.finish();
  const std::vector<Measured> all = measure(scans);
  if (all.empty()) {
    throw Error(
        "these scans measure no noise; give two alike of one unmoved scene, one of 4-step pmp, or "
        "one of pcmp with 5 steps or more");
  }
  const Measured& trusted = all.front();
  output.document["measurements"] = nlohmann::json::array();
  for (const Measured& measured : all) {
    const std::string reason = disagreement(measured, trusted);
    output.say("sigma_w^2 {:.4f}, standard error {:.2g}: Eq. ({}), {}, {} times{}{}",
               measured.variance(), measured.standard_error(), measured.equation, measured.method,
               measured.count, reason.empty() ? "" : "; ", reason);
    output.document["measurements"].push_back({{"equation", measured.equation},
                                               {"variance", measured.variance()},
                                               {"standard_error", measured.standard_error()},
                                               {"count", measured.count},
                                               {"pixels", measured.sum.pixels},
                                               {"agrees", reason.empty()},
                                               {"reason", reason}});
  }
  const std::string first = trusted.equation;
  if (first == "3.99" || first == "3.79") {
    output.warn(
        fmt::format("Eq. ({}) alone counts a response that is not linear as noise; two "
                    "scans alike would tell",
                    first));
  }
  output.document["noise_variance"] = trusted.variance();
  if (flags.files.output.empty()) {
    output.say("nothing was asked to be written; -o scanner.yaml writes it into a scanner file");
    return;
  }
  if (!(trusted.variance() > 0)) {
    throw Error("the scans differ in nothing, as copies do; noise is measured between two takes");
  }
  std::optional<fs::path> from = scans.front().scan.scanner;
  if (flags.files.scanner) from = *flags.files.scanner;
  write_photometric_calibration(from, flags.files.output,
                                {.ambient = {}, .noise_variance = trusted.variance()});
  output.document["output"] = flags.files.output;
  output.say("{}: sigma_w^2 {:.4f} written", flags.files.output, trusted.variance());
}

}  // namespace

void add_calibrate_noise(CLI::App& calibrate, SharedFlags& shared, Command& chosen) {
  CLI::App* command = calibrate.add_subcommand(
      "noise", "the variance of the frames' noise, by all measurements that the scans allow");
  const auto flags = std::make_shared<CalibrateNoiseFlags>();
  command->add_option("folders", flags->folders, "scan folders of one unmoved scene")->required();
  add_calibration_files(*command, flags->files);
  add_scan_flags(*command, flags->scan);
  add_shared_flags(*command, shared);
  command->footer("Example:\n  slipstream calibrate noise scan_1 scan_2 scan_3 -o scanner.yaml");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { calibrate_noise(*flags, output); }; });
}

}  // namespace slipstream::app
