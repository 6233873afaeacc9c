#include "slipstream/check/explanations.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "slipstream/check/frame_faults.h"
#include "slipstream/check/mistake_search.h"

namespace slipstream {
namespace {

std::vector<Evidence> relation_evidence(const FrameEvidence& frames) {
  const auto worst = std::min_element(
      frames.relations.begin(), frames.relations.end(), [](const auto& a, const auto& b) {
        return a.agreement - std::abs(a.offset) < b.agreement - std::abs(b.offset);
      });
  if (worst == frames.relations.end()) return {};
  return {{"agreement", worst->agreement}, {"offset in periods", worst->offset}};
}

/// What of it does not fit, the clearest first.
Finding seen(const Fit& fit) {
  Finding finding{.gravity = Gravity::wrong};
  const auto& geometry = fit.geometry;
  if (!fit.patterns_made()) {
    finding.what = "the frames are not what these patterns make";
    finding.evidence = {{"left over, share of their variation", fit.frames.residual}};
  } else if (!fit.bands_alike()) {
    finding.what = "the bands are lit unlike each other from pixel to pixel";
    finding.evidence = {{"spread of their modulations' ratio", fit.frames.ratio_spread}};
  } else if (!fit.bands_agree()) {
    finding.what = "the frames disagree about the fringe order";
    finding.evidence = relation_evidence(fit.frames);
  } else if (!fit.no_seam()) {
    finding.what = "the coordinate leaps from one end of the field to the other in the light";
    finding.evidence = {{"share of the pixels near it", fit.frames.seams}};
  } else if (!fit.geometry_fits()) {
    finding.what = "frames and scanner do not fit together";
    finding.evidence = {{"slope of the coordinate", geometry->slope},
                        {"share outside the projector's light", geometry->outside},
                        {"share without a point", geometry->without_point}};
  } else {
    finding.what = "most points lie outside of the depths that were calibrated";
    finding.evidence = {{"share", geometry->out_of_range},
                        {"median depth, mm", geometry->median_depth}};
  }
  return finding;
}

/// Where no usual mistake explains it.
void name_broadly(const Fit& fit, Finding& finding) {
  const auto& geometry = fit.geometry;
  // So few pixels are right then that none can be told from the wrong ones.
  constexpr double hopeless_agreement = 0.35, hopeless_offset = 0.25, hopeless_residual = 0.2;
  constexpr double hopeless_outside = 0.6;
  finding.gravity = Gravity::doubtful;
  if (!fit.patterns_made() || !fit.bands_agree() || !fit.no_seam()) {
    const auto hopeless = [](const BandRelation& relation) {
      return relation.agreement < hopeless_agreement || std::abs(relation.offset) > hopeless_offset;
    };
    const auto& relations = fit.frames.relations;
    if (fit.frames.residual > hopeless_residual ||
        std::any_of(relations.begin(), relations.end(), hopeless)) {
      finding.gravity = Gravity::wrong;
    }
    finding.likely = "other patterns than said, frames lost or mixed up, or something moved";
    finding.advice = "compare the pictures with those of slipstream patterns";
  } else if (!fit.geometry_fits()) {
    if (geometry->outside + geometry->without_point > hopeless_outside)
      finding.gravity = Gravity::wrong;
    finding.likely =
        "a scanner file of another rig, pictures cropped or of another size, or a camera or "
        "projector that moved since the calibration";
    finding.advice = "check the file, and calibrate again where the rig was touched";
  } else {
    finding.likely =
        "something nearer or farther than the boards were, or a scanner file of another rig";
    finding.advice = "calibrate with boards at those depths, or check the order of the frames";
  }
}

/// Light that changed between frames.
std::optional<Finding> flicker(const JudgedScan& scan, const Fit& fit) {
  // Right scans leave more at times, a real skull 0.0085, but then no gains explain it: at most
  // 0.62 of it, and by half a percent. Lamps and exposures do not change by more than the last.
  constexpr double least_residual = 0.003, least_explained = 0.7, least_gain = 0.025;
  constexpr double most_gain = 0.3;
  if (fit.frames.residual < least_residual) return std::nullopt;
  const FrameGains gains = frame_gains(scan.model, scan.samples);
  const auto odd = std::max_element(gains.gains.begin(), gains.gains.end(),
                                    [](double a, double b) { return std::abs(a) < std::abs(b); });
  const double size = std::abs(*odd);
  if (!(gains.explained >= least_explained && size >= least_gain && size <= most_gain)) {
    return std::nullopt;
  }
  // Motion may look like light, but hardly like that of one frame alone.
  if (scan.moving && !gains.odd_frame) return std::nullopt;
  Finding finding{
      .what = "frames are brighter or darker than the patterns make them",
      .likely = "light that flickers, or an exposure or gain that changed between frames",
      .advice =
          "fix exposure and gain, and expose for whole periods of the mains and the projector"};
  if (gains.odd_frame) {
    finding.evidence = {
        {fmt::format("frame {}, percent", gains.odd_frame->frame), 100 * gains.odd_frame->gain}};
  } else {
    finding.evidence = {{"the most, percent", 100 * size}};
  }
  return finding;
}

/// Frames without any pattern, where they are no dark part of one.
std::vector<Finding> dark_frames(const JudgedScan& scan, const Fit& fit) {
  // Frames that contradict each other so much have lost one; where they cannot, what the scene sees
  // of the patterns must make it bright somewhere.
  constexpr double contradicting = 0.2, least_of_pattern = 0.5;
  if (scan.model.unexplained_count() > 0 && fit.frames.residual < contradicting) return {};
  if (!scan.model.has_redundancy()) {
    for (int n = 0; n < scan.samples.frames(); ++n) {
      if (scan.model.shown_range(n, scan.samples) < least_of_pattern) return {};
    }
  }
  return slipstream::dark_frames(scan.samples);
}

}  // namespace

Explained explain(const JudgedScan& scan) {
  if (scan.samples.groups() < ScanSamples::fewest_groups) return {};
  Explained result;
  const Fit fit = fit_as_given(scan);
  auto flickering = flicker(scan, fit);
  if (fit.all()) {
    // Where frames say something of each other a dark one would not have fitted.
    if (!scan.model.has_redundancy()) result.findings = dark_frames(scan, fit);
    if (flickering && result.findings.empty()) result.findings.push_back(std::move(*flickering));
    return result;
  }
  Finding finding = seen(fit);
  const bool only_depths =
      fit.bands_agree() && fit.patterns_made() && fit.no_seam() && fit.geometry_fits();
  if (auto explanation = likeliest_mistake(scan, fit)) {
    if (only_depths) {
      // The scene may be where no board was, as well.
      explanation->gravity = Gravity::doubtful;
      explanation->likely += ", or something nearer or farther than the boards were";
    }
    finding.likely = std::move(explanation->likely);
    finding.advice = std::move(explanation->advice);
    finding.gravity = explanation->gravity;
    result.order = std::move(explanation->order);
  } else if (std::vector<Finding> faults = dark_frames(scan, fit); !faults.empty()) {
    result.findings = std::move(faults);
    return result;
  } else if (flickering) {
    finding = std::move(*flickering);
  } else {
    name_broadly(fit, finding);
  }
  result.findings.push_back(std::move(finding));
  return result;
}

}  // namespace slipstream
