#include "check/dark_frames.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <vector>

#include "base/statistics.h"
#include "check/frame_faults.h"

namespace slipstream {
namespace {

/// Frames that vary over a scene only if frame n does: those of its bands; of a code the next
/// coarser bit, or the bit that an inverse inverts. nullopt for a uniform pattern.
std::optional<std::vector<int>> frames_beside(const Layout& layout, int n) {
  std::vector<int> beside;
  bool varies = false;

  // The other frames of the bands that frame n belongs to.
  for (const Band& band : layout.bands) {
    const auto is_in = [&](int m) {
      return !layout.unwrapping->whole_stripes && (band.cosine[m] != 0 || band.sine[m] != 0);
    };

    if (!is_in(n)) continue;
    varies = true;
    for (int m = 0; m < layout.frames; ++m) {
      if (m != n && is_in(m)) beside.push_back(m);
    }
  }

  // In a code: the bit that an inverse inverts, or the next coarser bit.
  if (!layout.code) return beside;
  const std::vector<int>&bits = layout.code->frames, &inverses = layout.code->inverses;
  const auto bit = std::ranges::find(bits, n), inverse = std::ranges::find(inverses, n);

  // Frames with a common base all share its edges, so that their coarser bits prove little.
  if (inverse != inverses.end()) {
    beside.push_back(bits[inverse - inverses.begin()]);
  } else if (bit != bits.end() && bit != bits.begin() && !layout.code->base) {
    beside.push_back(*std::prev(bit));
  }

  varies |= bit != bits.end() || inverse != inverses.end();
  return varies ? std::optional(beside) : std::nullopt;
}

/// How much of a pixel's range a frame covers over the lit pixels, 0 to 1.
double shown_range(const ScanSamples& samples, int n) {
  std::vector<double> shares;

  for (std::size_t g = 0; g < samples.groups(); ++g) {
    const float* const levels = samples.levels(g, ScanSamples::middle);
    const auto [least, greatest] = std::minmax_element(levels, levels + samples.frames());
    shares.push_back((levels[n] - *least) / std::max(1.0F, *greatest - *least));
  }

  // Without the outliers at either end.
  const double most = quantile(shares, 0.95);
  return most - quantile(shares, 0.05);
}

}  // namespace

std::vector<Finding> dark_frames(const JudgedScan& scan, bool lost) {
  constexpr double least_shown = 0.7;
  const auto is_shown = [&](int n) { return shown_range(scan.samples, n) >= least_shown; };

  std::vector<Finding> findings;
  for (int n = 0; n < scan.samples.frames(); ++n) {
    auto finding = without_pattern(scan.samples, n);
    if (!finding) continue;

    // If no other frame is bright, the scene may lie in the dark part of the pattern.
    const auto beside = frames_beside(scan.model.layout(), n);
    const bool reached = beside && (lost || std::ranges::any_of(*beside, is_shown));
    if (reached) findings.push_back(std::move(*finding));
  }

  return findings;
}

}  // namespace slipstream
