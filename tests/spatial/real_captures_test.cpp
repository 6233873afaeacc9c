// Captures by others, unwrapped in space and held against what further frames say.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/image_file.h"
#include "slipstream/spatial_unwrapping.h"
#include "tests/shared_data.h"
#include "tests/spatial/known_phase.h"

namespace slipstream::real_captures_test {

constexpr double period = 2 * std::numbers::pi;

struct Phase {
  Image<float> wrapped, modulation;
};

/// Of frames that show I = A + B cos(phase - 2 pi n / N).
Phase phase_of(const std::vector<std::filesystem::path>& paths) {
  std::vector<Image<double>> frames;
  for (const auto& path : paths) frames.push_back(read_levels(path));
  Phase phase{Image<float>(frames.front().size()), Image<float>(frames.front().size())};
  const auto count = static_cast<double>(frames.size());
  for (std::size_t i = 0; i < phase.wrapped.pixel_count(); ++i) {
    double sine = 0, cosine = 0;
    for (std::size_t n = 0; n < frames.size(); ++n) {
      const double turn = period * static_cast<double>(n) / count;
      sine += frames[n].begin()[i] * std::sin(turn);
      cosine += frames[n].begin()[i] * std::cos(turn);
    }
    phase.wrapped.begin()[i] = static_cast<float>(std::atan2(sine, cosine));
    phase.modulation.begin()[i] = static_cast<float>(2 / count * std::hypot(sine, cosine));
  }
  return phase;
}

/// The share that each method has right; printed, for docs/how-to/unwrap-phase-maps.md.
std::map<std::string, double> shares(const KnownPhase& known, const Image<float>& quality) {
  std::map<std::string, double> all;
  for (const SpatialUnwrapping& method : spatial_unwrappings()) {
    const auto start = std::chrono::steady_clock::now();
    const auto unwrapped = unwrap_in_space(known.wrapped, quality, method.name);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    const double share = all[std::string(method.name)] = right_share(known, unwrapped.phase);
    std::printf("  %-13s right %8.4f %%, %zu regions, %.2f s\n", std::string(method.name).c_str(),
                100 * share, unwrapped.regions.size(), took.count());
  }
  return all;
}

TEST(RealCaptures, APlaneIsUnwrappedAsByItsOtherFrequencies) {
  const auto folder = shared_data() / "cpsd-plane";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  std::vector<std::filesystem::path> frames;
  for (int n = 1; n <= 12; ++n) frames.push_back(folder / fmt::format("f4_s{:02}.png", n));
  Phase phase = phase_of(frames);
  // The authors' phase runs the other way around.
  for (float& each : phase.wrapped) each = -each + static_cast<float>(std::numbers::pi);
  KnownPhase known{Image<float>(phase.wrapped.size()), phase.wrapped};
  const Image<double> temporal = read_map(folder / "phase_authors.tiff");
  const Image<double> mask = read_levels(folder / "mask_authors.png");
  for (std::size_t i = 0; i < temporal.pixel_count(); ++i) {
    known.truth.begin()[i] = static_cast<float>(temporal.begin()[i]);
    if (mask.begin()[i] > 0) continue;
    known.truth.begin()[i] = known.wrapped.begin()[i] = std::numeric_limits<float>::quiet_NaN();
  }
  const auto right = shares(known, phase.modulation);
  for (const char* method : {"branch-cuts", "quality", "flow"})
    EXPECT_GT(right.at(method), 0.999) << method;
}

TEST(RealCaptures, ASkullBesideItsUnitFrequency) {
  const auto folder = shared_data() / "skull" / "dual-frequency";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto frame = [&](int n) { return folder / fmt::format("frameSeq_{:02}.png", n); };
  const Phase high = phase_of({frame(0), frame(1), frame(2)});
  const Phase low = phase_of({frame(3), frame(4), frame(5)});
  KnownPhase known{high.wrapped, high.wrapped};
  for (std::size_t i = 0; i < known.truth.pixel_count(); ++i) {
    const double unit =
        low.wrapped.begin()[i] < 0 ? low.wrapped.begin()[i] + period : low.wrapped.begin()[i];
    const double wrapped = high.wrapped.begin()[i];
    known.truth.begin()[i] =
        static_cast<float>(wrapped + period * std::rint((16 * unit - wrapped) / period));
    if (high.modulation.begin()[i] >= 15 && low.modulation.begin()[i] >= 15) continue;
    known.truth.begin()[i] = known.wrapped.begin()[i] = std::numeric_limits<float>::quiet_NaN();
  }
  const auto right = shares(known, high.modulation);
  EXPECT_GT(right.at("flow"), 0.9);
}

}  // namespace slipstream::real_captures_test
