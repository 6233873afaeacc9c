#include "check/damaged_frames.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "base/statistics.h"

namespace slipstream {
namespace {

using Places = std::vector<std::size_t>;  ///< groups, from the top of the picture to the bottom

float level_in(const ScanSamples& samples, std::size_t group, int frame) {
  return samples.levels(group, ScanSamples::middle)[frame];
}

struct Stretch {
  std::size_t length = 0, end = 0;  ///< in the order of the places
};

/// The longest run of lit pixels, from top to bottom, that all have a property.
template <class Has>
Stretch longest_stretch(const Places& places, const Has& has) {
  Stretch longest;
  std::size_t length = 0;

  for (std::size_t i = 0; i < places.size(); ++i) {
    length = has(places[i]) ? length + 1 : 0;
    if (length > longest.length) longest = {length, i + 1};
  }

  return longest;
}

double share_of(const Stretch& stretch, const Places& places) {
  return static_cast<double>(stretch.length) / static_cast<double>(places.size());
}

/// `limit`: of the share that the finding is about.
std::vector<Evidence> evidence_of(const Stretch& stretch, const Places& places,
                                  const ScanSamples& samples, double limit) {
  const double first = samples.row(places[stretch.end - stretch.length]);
  const double last = samples.row(places[stretch.end - 1]);
  return {{.name = "share of the lit pixels", .value = share_of(stretch, places), .limit = limit},
          {"first row", first},
          {"last row", last}};
}

// Shares of the lit pixels.
constexpr double part = 0.12, all = 0.97;

/// Whether frame n is as dark as any in nearly all pixels of a stretch, or as bright, and without
/// noise, which compression removes: then frames of a code are equal in wide stripes.
bool is_flat_black_or_white(const ScanSamples& samples, const Places& places,
                            const Stretch& stretch, int n) {
  constexpr float near = 0.1F;  // of the pixel's range
  constexpr double nearly_all = 0.95, mostly = 0.7;
  constexpr float rounding = 1e-3F;

  double black = 0, white = 0, flat = 0, beside = 0;
  for (std::size_t i = stretch.end - stretch.length; i < stretch.end; ++i) {
    const float* const levels = samples.levels(places[i], ScanSamples::middle);
    const auto [least, greatest] = std::minmax_element(levels, levels + samples.frames());
    const float margin = near * (*greatest - *least);
    if (levels[n] < *least + margin) ++black;
    if (levels[n] > *greatest - margin) ++white;

    if (!samples.lit(places[i], ScanSamples::right)) continue;
    ++beside;
    if (std::abs(levels[n] - samples.levels(places[i], ScanSamples::right)[n]) < rounding) ++flat;
  }

  return std::max(black, white) > nearly_all * static_cast<double>(stretch.length) &&
         flat > mostly * beside;
}

/// Frames of different patterns are equal only where their sinusoids cross.
std::optional<Finding> same_picture(const ScanSamples& samples, const Places& places, int n,
                                    int m) {
  // Equal intensities may differ by this through rounding.
  constexpr float rounding = 1e-3F;
  constexpr std::size_t fewest = 24;  // fewer may be equal by chance

  const Stretch alike = longest_stretch(places, [&](std::size_t group) {
    return std::abs(level_in(samples, group, n) - level_in(samples, group, m)) < rounding;
  });

  const double share = share_of(alike, places);
  if (share < part || alike.length < fewest) return std::nullopt;
  if (share <= all && is_flat_black_or_white(samples, places, alike, n)) return std::nullopt;

  const double limit = share > all ? all : part;
  Finding finding{.evidence = evidence_of(alike, places, samples, limit), .frames = {n, m}};
  if (share > all) {
    finding.kind = FindingKind::repeated_frame;
    finding.severity = Severity::wrong;
    finding.what = fmt::format(
        "frames {} and {} are the same picture in over {:g} % of the lit pixels", n, m, 100 * all);
    finding.causes = {{CauseKind::repeated_frame,
                       fmt::format("a frame saved twice, in place of frame {} or {}", n, m)}};
    finding.remedies = {{"capture the scan again"}};
  } else {
    finding.kind = FindingKind::partly_repeated_frame;
    finding.what = fmt::format("frames {} and {} are the same in over {:g} % of the lit pixels", n,
                               m, 100 * part);
    finding.causes = {
        {CauseKind::lost_data,
         fmt::format("part of frame {} or {} was lost and still shows the frame before it", n, m)}};
    finding.remedies = {{"capture the scan again; check the camera's link for lost packets"}};
  }

  return finding;
}

/// Finds rows that turn black abruptly: the dark part of a pattern begins gradually.
std::optional<Finding> lost_part(const ScanSamples& samples, const Places& places, int n) {
  constexpr float black = 0.5F;
  // Minimum grey level next to the lost rows; the edge of a pattern's dark part is darker.
  constexpr float sharp = 12;

  const Stretch lost = longest_stretch(
      places, [&](std::size_t group) { return level_in(samples, group, n) <= black; });

  const double share = share_of(lost, places);
  if (share < part || share > all) return std::nullopt;

  // Levels just above and below the lost rows: a twentieth of the lit pixels each.
  std::vector<float> beside;
  const std::size_t first = lost.end - lost.length, near = places.size() / 20 + 1;
  for (std::size_t i = first - std::min(first, near); i < std::min(places.size(), lost.end + near);
       ++i) {
    if (i < first || i >= lost.end) beside.push_back(level_in(samples, places[i], n));
  }

  if (beside.empty() || quantile(beside, 0.5) < sharp) return std::nullopt;

  return Finding{
      .kind = FindingKind::partly_black_frame,
      .what = fmt::format("frame {} is black in over {:g} % of the lit pixels", n, 100 * part),
      .evidence = evidence_of(lost, places, samples, part),
      .causes = {{CauseKind::lost_data, fmt::format("part of frame {} was lost in transfer", n)}},
      .remedies = {{"capture the scan again; check the camera's link for lost packets"}},
      .frames = {n}};
}

}  // namespace

std::vector<Finding> damaged_frames(const ScanSamples& samples) {
  std::vector<Finding> findings;
  if (samples.groups() < ScanSamples::fewest_groups) return findings;

  // From top to bottom, the order in which a camera transfers its rows.
  Places places(samples.groups());
  std::iota(places.begin(), places.end(), std::size_t{0});
  std::ranges::sort(places, {}, [&](std::size_t group) { return samples.row(group); });

  const auto add = [&](std::optional<Finding> finding) {
    if (finding) findings.push_back(std::move(*finding));
  };

  for (int n = 0; n < samples.frames(); ++n) {
    add(lost_part(samples, places, n));
    for (int m = n + 1; m < samples.frames(); ++m) add(same_picture(samples, places, n, m));
  }

  return findings;
}

}  // namespace slipstream
