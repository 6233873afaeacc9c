// Real captures by others whose projectors bend the phase: corrected by responses measured from
// frames of the same rig.
// Real pictures from a nearly linear projector: the blind correction does no harm.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "decode/decoder.h"
#include "decode/phase_decoder.h"
#include "io/image_file.h"
#include "response/correction.h"
#include "response/gamma_calibration.h"
#include "response/harmonics.h"
#include "response/scan_average.h"
#include "slipstream/gamma.h"
#include "slipstream/gray_code.h"
#include "slipstream/strategy.h"
#include "tests/shared_data.h"

namespace slipstream::captures_gamma_test {
namespace fs = std::filesystem;

constexpr double pi = std::numbers::pi;
constexpr int no_end = 1 << 24;  // projector pixels: no coordinate is brought to the other end

std::string two_digits(int n) {
  return (n < 10 ? "0" : "") + std::to_string(n);
}

/// RMS of how far two phases are apart, rad, in the pixels where `lit` is set, less their mean.
double rms_apart(const Image<double>& a, const Image<double>& b, const Image<std::uint8_t>& lit) {
  double sum = 0, square = 0, count = 0;
  for (std::size_t i = 0; i < lit.pixel_count(); ++i) {
    if (lit.begin()[i] == 0) continue;
    const double apart = std::remainder(a.begin()[i] - b.begin()[i], 2 * pi);
    if (std::abs(apart) > 1) continue;  // the code between two stripes
    sum += apart;
    square += apart * apart;
    ++count;
  }
  EXPECT_GT(count, 100000);
  return std::sqrt(square / count - sum / count * (sum / count));
}

Image<double> wrapped_phase(const FrameViews& frames, const Strategy& strategy,
                            const PhaseCorrections& corrections) {
  return PhaseDecoder(PhaseMethod::equation, {}, corrections)(frames, strategy.layout().bands[0])
      .wrapped_phase;
}

TEST(CapturesGamma, ThreeOfTwelveStepsAreCorrected) {
  const fs::path folder = shared_data() / "cpsd-plane";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  std::vector<fs::path> files;
  for (int step = 1; step <= 12; ++step) {
    files.push_back(folder / ("f4_s" + two_digits(step) + ".png"));
  }
  const LoadedFrames loaded = read_frames(files);
  const FrameViews frames = loaded.frames;
  const Shifts shifts{pi, true};
  const auto steps = [&](int N) { return PhaseMeasuring{N, 64, shifts}; };
  ScanAverage scans;
  Scan scan;
  scan.frames = loaded.frames;
  scan.sequence.strategy = steps(12);
  scans.add(scan, "f4");
  const GammaCalibration calibration = calibrate_gamma(scans);
  const Response response = found_response(calibration).response;

  const Decoder decode(Strategy(steps(12)).layout(), no_end, PhaseMethod::equation);
  const BasicMaps<double> truth = decode(frames);
  Image<std::uint8_t> lit(frames.size());
  std::transform(truth.modulation.begin(), truth.modulation.end(), lit.begin(),
                 [](double B) { return static_cast<std::uint8_t>(B > 40 ? 1 : 0); });
  for (const auto& [N, before] : {std::pair{3, 0.1535}, {4, 0.0108}, {6, 0.0077}}) {
    std::vector<int> chosen;
    for (int n = 0; n < N; ++n) chosen.push_back(12 / N * n);
    const FrameViews some = frames.chosen(chosen);
    const double uncorrected =
        rms_apart(wrapped_phase(some, steps(N), {}), truth.wrapped_phase, lit);
    const double corrected = rms_apart(
        wrapped_phase(some, steps(N), PhaseCorrections{{N, phase_correction(response, N)}}),
        truth.wrapped_phase, lit);
    std::printf("%d of 12 steps: %.4f rad, corrected %.4f\n", N, uncorrected, corrected);
    EXPECT_NEAR(uncorrected, before, 0.02 * before);
    // Four and six steps are bent so little that noise is all there is.
    EXPECT_LE(corrected, N == 3 ? 0.0165 : 1.01 * uncorrected);
  }
}

/// Medians of what is seen at values of the pattern, between black and white.
ResponseCurve measured_response(const std::vector<std::pair<double, double>>& seen) {
  constexpr int pieces = 32;
  std::vector<std::vector<double>> bins(pieces + 1);
  for (const auto& [value, level] : seen) {
    bins[static_cast<std::size_t>(std::lround(value * pieces))].push_back(level);
  }
  std::vector<double> values, levels;
  for (int i = 0; i <= pieces; ++i) {
    auto& bin = bins[static_cast<std::size_t>(i)];
    if (bin.size() < 100) continue;
    std::nth_element(bin.begin(), bin.begin() + static_cast<std::ptrdiff_t>(bin.size() / 2),
                     bin.end());
    values.push_back(static_cast<double>(i) / pieces);
    levels.push_back(bin[bin.size() / 2]);
  }
  return response_curve(values, levels);
}

TEST(CapturesGamma, ThreeStepsOfTwoPreGammasAreCorrectedByOneResponse) {
  const fs::path folder = shared_data() / "kamino-gamma";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto frames_of = [&](int first, int last) {
    std::vector<fs::path> some;
    for (int n = first; n <= last; ++n) some.push_back(folder / ("pat" + two_digits(n) + ".png"));
    return read_frames(some);
  };
  constexpr int columns = 1920;
  const LoadedFrames code = frames_of(12, 31), ends = frames_of(52, 53);
  const BasicMaps<double> by_code =
      Decoder(Strategy(GrayCode{.reference = "inverse", .stripes = columns / 2.0}).layout(),
              columns, PhaseMethod::equation)(code.frames);
  const Image<double> white = weighted_sum(ends.frames, {1, 0});
  const Image<double> black = weighted_sum(ends.frames, {0, 1});
  const Strategy strategy = PhaseMeasuring{3, columns / 240.0, {-2 * pi / 3, true}};
  Image<double> true_phase(white.size());
  Image<std::uint8_t> lit(white.size());
  for (std::size_t i = 0; i < lit.pixel_count(); ++i) {
    true_phase.begin()[i] = 2 * pi * columns / 240.0 * by_code.coordinate.begin()[i];
    lit.begin()[i] = white.begin()[i] - black.begin()[i] > 60 ? 1 : 0;
  }
  const std::vector<std::pair<double, LoadedFrames>> scans{{0.75, frames_of(0, 2)},
                                                           {1.25, frames_of(3, 5)}};
  std::vector<std::pair<double, double>> seen;
  for (const auto& [pre_gamma, loaded] : scans) {
    for (int n = 0; n < 3; ++n) {
      std::vector<double> only(3);
      only[static_cast<std::size_t>(n)] = 1;
      const Image<double> level = weighted_sum(loaded.frames, only);
      for (std::size_t i = 0; i < lit.pixel_count(); i += 7) {
        if (lit.begin()[i] == 0) continue;
        const double shape =
            std::clamp(0.5 + 0.5 * std::cos(true_phase.begin()[i] + (n - 1) * 2 * pi / 3), 0., 1.);
        seen.emplace_back(
            std::pow(shape, 1 / pre_gamma),
            (level.begin()[i] - black.begin()[i]) / (white.begin()[i] - black.begin()[i]));
      }
    }
  }
  const Response response = measured_response(seen);
  for (const auto& [pre_gamma, before, after] :
       {std::tuple{0.75, 0.193, 0.023}, {1.25, 0.072, 0.021}}) {
    const FrameViews frames = (pre_gamma < 1 ? scans[0] : scans[1]).second.frames;
    // What the sinusoid that is meant meets on its way: the picture's gamma, then the projector.
    std::vector<double> values, light;
    for (int i = 0; i <= 256; ++i) {
      values.push_back(i / 256.0);
      light.push_back(light_at(response, std::pow(i / 256.0, 1 / pre_gamma)));
    }
    const PhaseCorrections corrections = {{3, phase_correction(response_curve(values, light), 3)}};
    const double uncorrected = rms_apart(wrapped_phase(frames, strategy, {}), true_phase, lit);
    const double corrected =
        rms_apart(wrapped_phase(frames, strategy, corrections), true_phase, lit);
    std::printf("pre-gamma %.2f: %.4f rad, corrected %.4f\n", pre_gamma, uncorrected, corrected);
    EXPECT_NEAR(uncorrected, before, 0.03 * before);
    EXPECT_LE(corrected, after);
  }
}

constexpr int projector_columns = 1824;

FrameSet frames_of(const fs::path& folder, int count) {
  std::vector<fs::path> paths;
  for (int n = 0; n < count; ++n) {
    paths.push_back(folder / ("frameSeq_0" + std::to_string(n) + ".png"));
  }
  return read_frames(paths).frames;
}

/// RMS of the phase error of three steps, rad, against the dual-frequency scan of the same object.
double rms_error(const FrameSet& three_steps, const BasicMaps<double>& truth,
                 const Image<std::uint8_t>& lit, const PhaseCorrections& corrections) {
  const Decoder decode(PhaseMeasuring{3, 1}.layout(), projector_columns, PhaseMethod::tables,
                       corrections);
  const BasicMaps<double> decoded = decode(three_steps);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < lit.pixel_count(); ++i) {
    if (lit.begin()[i] == 0 || truth.modulation.begin()[i] < 15) continue;
    const double error =
        2 * std::numbers::pi *
        std::remainder(decoded.coordinate.begin()[i] - truth.coordinate.begin()[i], 1);
    if (std::abs(error) > 0.3) continue;  // another fringe order of the truth
    sum += error * error;
    ++count;
  }
  EXPECT_GT(count, 200000);
  return std::sqrt(sum / count);
}

TEST(CapturesGamma, SkullGammaBlindCorrectionDoesNoHarm) {
  const fs::path skull = shared_data() / "skull";
  if (!fs::exists(skull)) GTEST_SKIP() << "no " << skull;
  const FrameSet frames = frames_of(skull / "pmp", 3);
  const BasicMaps<double> truth =
      Decoder(DualFrequency{.steps = 3, .high = 16}.layout(), projector_columns,
              PhaseMethod::tables)(frames_of(skull / "dual-frequency", 6));
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, 0, 3);
  const Image<std::uint8_t> lit = well_lit(pixels, frames);
  const BlindGamma found = find_gamma(pixels, lit, 3);
  PhaseCorrections corrections;
  if (found.accepted()) corrections[3] = phase_correction(PowerLaw{found.gamma}, 3);
  const double before = rms_error(frames, truth, lit, {});
  const double after = rms_error(frames, truth, lit, corrections);
  std::cout << "gamma " << found.gamma << " +- " << found.standard_error << ", "
            << reason_of(found.refusal) << "; RMS " << before << " rad before, " << after
            << " after\n";
  EXPECT_LE(after, 1.02 * before);
}

}  // namespace slipstream::captures_gamma_test
