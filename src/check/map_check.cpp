#include "check/map_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/numbers.h"
#include "base/statistics.h"
#include "check/explanations.h"
#include "check/map_evidence.h"
#include "check/map_mistakes.h"
#include "check/method_limits.h"
#include "check/mistake_search.h"
#include "check/scan_samples.h"
#include "check/scanner_faults.h"

namespace slipstream {
namespace {

/// A value, and how many pixels have exactly that.
struct SharedValue {
  double value = 0;
  std::size_t pixels = 0;
};

/// The distinct values, least first.
std::vector<SharedValue> counted_values(const Image<double>& map) {
  std::vector<double> values = finite_values(map);
  std::ranges::sort(values);

  std::vector<SharedValue> counted;
  for (const double value : values) {
    if (counted.empty() || counted.back().value != value) counted.push_back({value, 0});
    ++counted.back().pixels;
  }
  return counted;
}

/// The values that invalid pixels were written as.
std::vector<SharedValue> values_of_invalid_pixels(const std::vector<SharedValue>& counted,
                                                  std::size_t pixels) {
  // Whole pixels or stripes are shared too. An edge of the field has few of them, so that the least
  // and the largest value stand out sooner.
  constexpr double least_share = 0.005, usual = 0.9;
  constexpr std::size_t between = 8, at_ends = 3;

  std::vector<std::size_t> counts;
  for (const SharedValue& value : counted) counts.push_back(value.pixels);
  const std::size_t typical = counts.empty() ? 0 : quantile(counts, usual);

  std::vector<SharedValue> found;
  for (std::size_t i = 0; i < counted.size(); ++i) {
    const bool is_at_end = i == 0 || i + 1 == counted.size();
    const std::size_t limit = (is_at_end ? at_ends : between) * typical;
    const double share = static_cast<double>(counted[i].pixels) / static_cast<double>(pixels);
    if (counted[i].pixels > limit && share >= least_share) found.push_back(counted[i]);
  }
  return found;
}

/// A map with its evidence.
struct JudgedMap {
  const MapEvidence& evidence;
  const MapForm& form;
  const Scanner& scanner;
  Axis axis;
};

MapFit fit_without(const JudgedMap& map, const MapEvidence& evidence, const MapMistake& undone) {
  const PossibleMistake& mistake = undone.mistake;
  const Scanner& scanner = mistake.scanner ? *mistake.scanner : map.scanner;
  const Axis axis = mistake.sequence ? mistake.sequence->axis : map.axis;
  return fit_of(changed(evidence, undone.scale, undone.shift), scanner, axis, mistake.turn);
}

/// The likeliest mistake that makes everything fit; nullopt if none does, or fits hardly better.
std::optional<Explanation> likeliest_map_mistake(const JudgedMap& map, const MapFit& as_given) {
  constexpr std::size_t few_samples = 128;
  constexpr double far_better = 0.5;

  // The first samples are spread over the map, too: most mistakes show in them.
  MapEvidence few = map.evidence;
  few.samples.resize(std::min(few.samples.size(), few_samples));

  std::vector<Attempt> found;
  for (MapMistake& undone : possible_map_mistakes(map.form, map.scanner, map.axis)) {
    const MapFit rough = fit_without(map, few, undone);
    if (!rough.scan.geometry_fits() || !rough.ends_fit()) continue;

    const MapFit fit = fit_without(map, map.evidence, undone);
    const double misfit = fit.misfit();

    // A map that fits as it is needs a far better explanation.
    const bool is_hardly_better =
        as_given.all() && (undone.mistake.far_fetched || misfit > as_given.misfit() - far_better);
    if (!fit.all() || is_hardly_better) continue;
    found.push_back({std::move(undone.mistake), fit.scan, misfit});
  }

  if (found.empty()) return std::nullopt;
  std::ranges::stable_sort(found, {}, [](const Attempt& attempt) {
    // Misfits within a step of this size count as equal: then the simplest comes first.
    constexpr double alike = 0.05;
    return std::floor(attempt.misfit / alike);
  });
  return explanation_from(found);
}

Evidence distance_of_end(const MapFit& fit) {
  return {.name = "distance of the light's end from the field's",
          .value = fit.end_error,
          .unit = "map pixels",
          .limit = MapFit::most_end_error};
}

/// Values that no projector coordinate has, or a whole map within a pixel.
std::optional<Finding> impossible_values(const Image<double>& coordinates, const JudgedMap& map,
                                         const MapFit& fit) {
  constexpr double outliers = 0.02, margin = 0.05;  // of the values; of the field
  std::vector<double> values = finite_values(coordinates);
  const double low = quantile(values, outliers), high = quantile(values, 1 - outliers);

  // As the map has them.
  const int length = length_along(map.axis, map.scanner.projector.size);
  const double origin = origin_of(map.form, length);
  const double slope = (map.form.backwards ? -1 : 1) * span_of(map.form, length);
  const auto value_at = [&](double coordinate) { return origin + slope * coordinate; };
  const std::string range =
      fmt::format("values from {:.4g} to {:.4g}", value_at(low), value_at(high));

  Finding finding{.kind = FindingKind::impossible_map_values, .severity = Severity::wrong};
  if ((high - low) * length < 1) {
    finding.what = fmt::format("{} lie in one projector pixel of {}", range, name_of(map.form));
    return finding;
  }

  const bool is_far_off = low < -margin || high > 1 + margin;
  if (!is_far_off && fit.is_in_field()) return std::nullopt;

  // Without an end of the light a few wrong values may be all.
  if (!is_far_off && fit.ends_fit()) finding.severity = Severity::doubtful;
  finding.what = fmt::format("{} exceed the projector, {:.6g} to {:.6g} for {}", range, value_at(0),
                             value_at(1), name_of(map.form));
  finding.evidence = {{.name = "share outside of the field",
                       .value = fit.exceeding,
                       .limit = MapFit::most_exceeding}};
  if (!fit.ends_fit()) finding.evidence.push_back(distance_of_end(fit));
  return finding;
}

Finding light_ends_elsewhere(const JudgedMap& map, const MapFit& fit) {
  Finding finding{.kind = FindingKind::light_ends_elsewhere,
                  .what = "the map ends along a line inside of the projector's field"};
  const auto add = [&](const std::optional<LightEnd>& end, const char* name) {
    if (end) finding.evidence.push_back({name, end->coordinate});
  };
  add(map.evidence.low, "least coordinate");
  add(map.evidence.high, "largest coordinate");
  finding.evidence.push_back(distance_of_end(fit));
  return finding;
}

/// What to look at if no common mistake explains the map.
void name_map_broadly(const MapFit& fit, Finding& finding) {
  constexpr double hopeless = 0.6;  // as for scans

  if (finding.kind == FindingKind::geometry_mismatch) {
    const GeometryEvidence& geometry = *fit.scan.geometry;
    if (geometry.outside + geometry.without_point <= hopeless) {
      finding.severity = Severity::doubtful;
    }
  }

  if (finding.kind == FindingKind::depths_beyond_boards) {
    finding.severity = Severity::doubtful;
    finding.causes = {beyond_the_boards(), {CauseKind::other_rig, "a scanner file of another rig"}};
    finding.remedies = {{"calibrate with boards at those depths"}};
    return;
  }

  finding.causes = {{CauseKind::unclear,
                     "a map in another form, a scanner file of another rig, or pictures cropped or "
                     "of another size"}};
  finding.remedies = {
      {fmt::format("expected {}; `origin` is the value at the edge of the field", map_forms)}};
}

/// The clearest symptom of a map that does not fit; nullopt if it fits.
std::optional<Finding> symptom_of(const Image<double>& coordinates, const JudgedMap& map,
                                  const MapFit& fit) {
  if (auto impossible = impossible_values(coordinates, map, fit)) return impossible;
  if (!fit.scan.geometry_fits()) return geometry_mismatch(*fit.scan.geometry, "map");
  if (!fit.scan.depths_fit()) return depths_beyond_boards(*fit.scan.geometry);
  if (!fit.ends_fit()) return light_ends_elsewhere(map, fit);
  if (!fit.scan.poor()) return std::nullopt;

  return Finding{.kind = FindingKind::better_settings,
                 .severity = Severity::wrong,
                 .what = "the map would fit far better with other settings",
                 .evidence = {{"median depth", fit.scan.geometry->median_depth, "mm"}}};
}

/// Adds the mistake that explains the symptom.
void name_map_mistake(Explanation explanation, const MapFit& fit, Finding& finding) {
  constexpr double clearly = 0.5;

  // Depths beyond the boards may be the scene's own: on their own they prove no mistake.
  const bool by_depths_alone =
      finding.kind == FindingKind::depths_beyond_boards ||
      (finding.kind == FindingKind::better_settings &&
       fit.misfit() - fit.scan.geometry->beyond < explanation.misfit + clearly);
  if (by_depths_alone) {
    finding.severity = Severity::doubtful;
    explanation.causes.push_back(beyond_the_boards());
  }

  give_causes(explanation, finding);
}

}  // namespace

std::vector<Finding> leave_out_shared_values(Image<double>& map) {
  const std::vector<SharedValue> counted = counted_values(map);
  std::vector<Finding> findings;

  for (const SharedValue& shared : values_of_invalid_pixels(counted, map.pixel_count())) {
    if (findings.size() + 1 == counted.size()) break;  // leaves at least one value
    std::ranges::replace(map, shared.value, nan);

    const double share =
        static_cast<double>(shared.pixels) / static_cast<double>(map.pixel_count());
    findings.push_back(
        {.kind = FindingKind::shared_map_value,
         .what = fmt::format("{} pixels, {:.1f} % of the map, have exactly the value {:g}: they "
                             "are left out",
                             shared.pixels, 100 * share, shared.value),
         .evidence = {{"value", shared.value}, {"share", share}},
         .causes = {{CauseKind::invalid_pixels, "invalid pixels written as a number"}},
         .remedies = {{"write NaN where a pixel is invalid"}}});
  }
  return findings;
}

CheckedScan check_map(const Image<double>& coordinates, const MapForm& form, const Scanner& scanner,
                      Axis axis) {
  // 1. An impossible scanner file makes further tests pointless.
  CheckedScan checked{.findings = check_scanner(scanner, false)};
  if (any_wrong(checked.findings)) return checked;

  // 2. The evidence, which few pixels do not give.
  const MapEvidence evidence = map_evidence(coordinates);
  if (evidence.samples.size() < ScanSamples::fewest_groups) return checked;

  const JudgedMap map{evidence, form, scanner, axis};
  const MapFit fit = fit_of(evidence, scanner, axis);
  checked.median_depth = fit.scan.geometry->median_depth;

  // 3. The symptom, and the likeliest mistake that explains it.
  std::optional<Finding> finding = symptom_of(coordinates, map, fit);
  if (!finding) {
    if (auto small = small_scale(scanner, checked.median_depth)) {
      checked.findings.push_back(*std::move(small));
    }
    return checked;
  }

  if (auto explanation = likeliest_map_mistake(map, fit)) {
    name_map_mistake(*std::move(explanation), fit, *finding);
  } else if (finding->kind == FindingKind::light_ends_elsewhere ||
             finding->kind == FindingKind::better_settings) {
    return checked;  // an object may end along a stripe, and lie beyond the boards
  } else {
    name_map_broadly(fit, *finding);
  }
  checked.findings.push_back(*std::move(finding));
  return checked;
}

}  // namespace slipstream
