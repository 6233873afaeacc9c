#include "check/frame_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/statistics.h"
#include "check/colour_mosaic.h"

namespace slipstream {
namespace {

float level(const ScanSamples& samples, std::size_t group, int frame) {
  return samples.levels(group, ScanSamples::middle)[frame];
}

/// Evidence about the light of a scan; grey levels of 255.
struct LightEvidence {
  /// Medians of the lit pixels, of the weakest and the strongest band, scaled to a sinusoid with
  /// all the light.
  double modulation = 0, strongest = 0;
  double mean = 0;  ///< median of the lit pixels' means over their frames
};

LightEvidence light_of(const FrameModel& model, const ScanSamples& samples) {
  LightEvidence light;
  const FrameOrder order = model.identity();
  std::vector<double> modulations, strongest, means;
  SampleReading reading;

  for (std::size_t g = 0; g < samples.groups(); ++g) {
    const float* const levels = samples.levels(g, ScanSamples::middle);
    means.push_back(std::accumulate(levels, levels + samples.frames(), 0.0) / samples.frames());

    model.read(levels, order, reading);
    for (std::size_t b = 0; b < reading.modulation.size(); ++b) {
      reading.modulation[b] /= model.layout().bands[b].share;
    }

    const auto [weakest, best] = std::ranges::minmax(reading.modulation);
    modulations.push_back(weakest);
    strongest.push_back(best);
  }

  if (!means.empty()) {
    light.modulation = quantile(modulations, 0.5);
    light.strongest = quantile(strongest, 0.5);
    light.mean = quantile(means, 0.5);
  }

  return light;
}

/// The fewest camera bits that hold these grey levels: 8, 10, 12, 14 or 16.
int bits_used(double brightest, int bits) {
  const double largest = brightest / 255 * ((1 << bits) - 1);
  int used = 8;
  while (used < bits && largest > (1 << used) - 1) used += 2;
  return used;
}

/// Share of the lit pixels that reach the top grey level in two frames or more, code frames
/// excluded; 0 if they are few of all that reach it, as at a sinusoid's crest.
double flat_topped(const FrameModel& model, const ScanSamples& samples) {
  constexpr double fewest_of_top = 0.25;

  std::vector<int> frames = measuring_frames(model.layout());
  // Further frames of a window show the same patterns again.
  if (const auto& cycle = measuring_band(model.layout()).cycle) frames.resize(cycle->steps);

  float top = 0;
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    for (const int n : frames) top = std::max(top, level(samples, g, n));
  }

  // A sinusoid's crest reaches the top in one frame of a pixel, clipping in several.
  std::size_t once = 0, flat = 0;
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    const auto count =
        std::ranges::count_if(frames, [&](int n) { return level(samples, g, n) == top; });
    if (count >= 1) ++once;
    if (count >= 2) ++flat;
  }

  if (flat == 0 || static_cast<double>(flat) < fewest_of_top * static_cast<double>(once)) return 0;
  return static_cast<double>(flat) / static_cast<double>(samples.groups());
}

Finding too_dark(const ScanSamples& samples, int bits, double least_modulation) {
  Finding finding{.kind = FindingKind::no_modulation,
                  .severity = samples.groups() == 0 ? Severity::wrong : Severity::doubtful,
                  .what = samples.groups() == 0
                              ? "no pixel reaches the minimum modulation"
                              : "under 0.3 % of the pixels reach the minimum modulation",
                  .evidence = {{"brightest grey level of 255", samples.brightest()},
                               {"largest change between frames", samples.largest_range()},
                               {"least modulation", least_modulation}}};

  const int used = bits_used(samples.brightest(), bits);

  if (samples.saturated_share() > 0.5) {
    finding.causes = {
        {CauseKind::overexposure, "too much light: the pictures are saturated everywhere"}};
    finding.remedies = {{"shorten the exposure or close the iris"}};
  } else if (bits == 16 && used <= 14) {
    finding.causes = {
        {CauseKind::bit_depth, fmt::format("pictures of {} bits in 16-bit files", used)},
        {CauseKind::underexposure, "far too little light"}};
    finding.remedies = {try_setting("camera_bits", std::to_string(used)),
                        {"lengthen the exposure"}};
  } else if (bits == 0 && samples.brightest() <= 1) {
    finding.causes = {
        {CauseKind::bit_depth, "real numbers from 0 to 1, where grey levels go to 255"},
        {CauseKind::dark_projector, "no light"}};
    finding.remedies = {{"multiply the frames by 255"}};
  } else if (samples.largest_range() < 4) {
    finding.causes = {{CauseKind::dark_projector,
                       "no pattern in the pictures: the projector was dark or not in view"}};
    finding.remedies = {{"check the projector and inspect the frames with `view()`"}};
  } else {
    finding.causes = {{CauseKind::underexposure,
                       "far too little light for this surface, or a very small object"}};
    finding.remedies = {{"lengthen the exposure, open the iris or darken the room"},
                        {"lower `minimum_modulation`"}};
  }

  return finding;
}

// Shares of the lit pixels.
constexpr double most_saturated = 0.2, most_flat = 0.015, most_dim = 0.5;

/// Ratio of the mean to the modulation: stronger ambient light leaves few grey levels for the
/// patterns.
constexpr double most_ambient = 5;

Finding unused_bits(int used, int bits, const ScanSamples& samples) {
  Finding finding{.kind = FindingKind::unused_bits,
                  .what = fmt::format("only {} of {} bits are used", used, bits),
                  .evidence = {{"brightest grey level of 255", samples.brightest()}},
                  .causes = {{CauseKind::bit_depth,
                              fmt::format("pictures of {} bits in {}-bit files", used, bits)}},
                  .remedies = {try_setting("camera_bits", std::to_string(used))}};

  if (used == 14) finding.causes.push_back({CauseKind::underexposure, "far too little light"});
  return finding;
}

Finding saturated(const ScanSamples& samples) {
  return {.kind = FindingKind::saturated,
          .what = fmt::format("saturated: over {:g} % of the lit pixels", 100 * most_saturated),
          .evidence = {{.name = "share of the lit pixels",
                        .value = samples.saturated_share(),
                        .limit = most_saturated}},
          .causes = {{CauseKind::overexposure, "too much light: the camera clips"}},
          .remedies = {{"shorten the exposure, close the iris or capture with `exposures 1,4`"}}};
}

Finding dim_light(const LightEvidence& light, double least_modulation) {
  Finding finding{
      .kind = FindingKind::low_modulation,
      .what = "too dark: the lit pixels' median modulation is below the minimum",
      .evidence = {{.name = "modulation", .value = light.modulation, .limit = least_modulation},
                   {"least modulation", least_modulation}},
      .causes = {{CauseKind::underexposure, "far too little light for this surface"}},
      .remedies = {{"lengthen the exposure, open the iris or darken the room"}}};

  // With enough light in the other bands, more of it would hardly help the weakest.
  constexpr double ample = 1.5;
  if (light.strongest < ample * least_modulation) return finding;

  finding.what = "the lit pixels' median modulation is below the minimum in one of the bands";
  finding.evidence.push_back({"of the strongest band", light.strongest});
  finding.causes = {
      {CauseKind::blur, "fringes blurred by a lens, or too narrow for the camera's pixels"}};
  finding.remedies = {{"focus both lenses, use larger pictures or fewer periods"}};
  return finding;
}

Finding dim_scene(const ScanSamples& samples, double least_modulation) {
  return {.kind = FindingKind::mostly_dark,
          .what = fmt::format("over {:g} % of the pixels that the patterns reach are too dark",
                              100 * most_dim),
          .evidence = {{.name = "share", .value = samples.dim_share(), .limit = most_dim},
                       {"least modulation", least_modulation}},
          .causes = {{CauseKind::underexposure, "far too little light for most of the scene"}},
          .remedies = {{"lengthen the exposure, capture with `exposures 1,4` or lower "
                        "`minimum_modulation`"}}};
}

Finding clipped(const ScanSamples& samples, double flat) {
  return {.kind = FindingKind::clipped,
          .what = fmt::format("clipped below saturation: over {:g} % of the lit pixels",
                              100 * most_flat),
          .evidence = {{.name = "share of the lit pixels", .value = flat, .limit = most_flat},
                       {"grey level", samples.brightest()}},
          .causes = {{CauseKind::clipped_pictures, "intensities clipped before they were saved"}},
          .remedies = {{"shorten the exposure; save the camera's frames unchanged"}}};
}

Finding bright_room(const LightEvidence& light) {
  return {
      .kind = FindingKind::strong_ambient_light,
      .what = fmt::format("the mean grey level is over {:g} times the modulation", most_ambient),
      .evidence = {{.name = "mean", .value = light.mean, .limit = most_ambient * light.modulation},
                   {"modulation", light.modulation}},
      .causes = {{CauseKind::ambient_light,
                  "ambient light stronger than the projector's, or a wrong black level"}},
      .remedies = {{"darken the room or brighten the projector"}}};
}

}  // namespace

std::optional<Finding> without_pattern(const ScanSamples& samples, int n) {
  std::vector<float> levels, ranges;
  std::size_t darkest = 0;

  for (std::size_t g = 0; g < samples.groups(); ++g) {
    const float* const levels_here = samples.levels(g, ScanSamples::middle);
    const float own = levels_here[n];

    // Range of the pixel in all other frames.
    float least = std::numeric_limits<float>::infinity(), greatest = -least;
    for (int m = 0; m < samples.frames(); ++m) {
      if (m == n) continue;
      least = std::min(least, levels_here[m]);
      greatest = std::max(greatest, levels_here[m]);
    }

    if (own <= least + 1) ++darkest;
    levels.push_back(own);
    ranges.push_back(greatest - least);
  }

  constexpr double nearly_all = 0.97;

  // Ambient light alone is nearly uniform, and nowhere brighter than the darkest pattern.
  const float range = quantile(ranges, 0.5), median = quantile(levels, 0.5);
  const float spread = quantile(levels, 0.98) - quantile(levels, 0.02);
  const double share = static_cast<double>(darkest) / static_cast<double>(samples.groups());
  if (share < nearly_all || spread > 0.08F * range + 2) return std::nullopt;

  return Finding{
      .kind = FindingKind::frame_without_pattern,
      .severity = Severity::wrong,
      .what = fmt::format("frame {} contains no pattern", n),
      .evidence = {{"its median", median, "grey levels"}, {"range of the others", range}},
      .causes = {{CauseKind::dark_projector,
                  fmt::format("frame {} is black: captured while the projector was dark", n)}},
      .remedies = {{"capture the scan again; check the trigger, or omit the marker frame"}},
      .frames = {n}};
}

std::vector<Finding> light_faults(const FrameModel& model, const ScanSamples& samples, int bits,
                                  double least_modulation) {
  const LightEvidence light = light_of(model, samples);

  // Share of all pixels: the area of a needle.
  constexpr double least_lit = 0.003;
  // Grey levels of 255, with room for rounding.
  constexpr double most_bright = 255.5;

  std::vector<Finding> findings;

  // 1. Wrong bits, or hardly any light: all else would mislead.
  if (samples.brightest() > most_bright) {
    return {{.kind = FindingKind::too_many_grey_levels,
             .severity = Severity::wrong,
             .what = "grey levels exceed the camera's maximum",
             .evidence = {{.name = "brightest, of the largest",
                           .value = samples.brightest() / 255,
                           .limit = most_bright / 255}},
             .causes = {{CauseKind::bit_depth, "a camera with more bits than declared"}},
             .remedies = {
                 try_setting("camera_bits", std::to_string(bits_used(samples.brightest(), 16)))}}};
  }

  // A small object that is well lit is fine.
  const bool dim = light.modulation < 1.5 * least_modulation;
  if (samples.groups() < ScanSamples::fewest_groups && samples.lit_share() < least_lit && dim) {
    return {too_dark(samples, bits, least_modulation)};
  }

  // 2. Otherwise each fault by itself.
  const int used = bits_used(samples.brightest(), bits);
  const double flat = flat_topped(model, samples);

  // The light is to blame once: for its ambient part if an exposure that suffices would saturate.
  const bool dark = light.modulation < least_modulation;
  const bool ambient = light.mean > most_ambient * light.modulation &&
                       (!dark || light.mean * least_modulation > 255 * light.modulation);

  if (auto filtered = colour_mosaic(samples)) findings.push_back(std::move(*filtered));

  if (bits == 16 && used < 16) findings.push_back(unused_bits(used, bits, samples));
  if (samples.saturated_share() > most_saturated) findings.push_back(saturated(samples));
  if (dark && !ambient) findings.push_back(dim_light(light, least_modulation));
  if (findings.empty() && samples.dim_share() > most_dim) {
    findings.push_back(dim_scene(samples, least_modulation));
  }
  if (flat > most_flat) findings.push_back(clipped(samples, flat));
  if (ambient) findings.push_back(bright_room(light));

  return findings;
}

}  // namespace slipstream
