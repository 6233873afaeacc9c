// Real pictures from a nearly linear projector: the blind correction does no harm.
#include <cmath>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/codes/registry.h"
#include "slipstream/decode/decoder.h"
#include "slipstream/io/image_file.h"
#include "slipstream/response/blind.h"
#include "slipstream/response/correction.h"
#include "tests/shared_data.h"

namespace slipstream::skull_gamma_test {
namespace fs = std::filesystem;

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

TEST(SkullGamma, BlindCorrectionDoesNoHarm) {
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
  if (found.accepted()) corrections[3] = phase_correction(PowerLaw{*found.accepted()}, 3);
  const double before = rms_error(frames, truth, lit, {});
  const double after = rms_error(frames, truth, lit, corrections);
  std::cout << "gamma " << found.gamma << " +- " << found.standard_error << ", "
            << reason_of(found.refusal) << "; RMS " << before << " rad before, " << after
            << " after\n";
  EXPECT_LE(after, 1.02 * before);
}

}  // namespace slipstream::skull_gamma_test
