#include "slipstream/finding.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace slipstream {
namespace {

/// In the order of the enumerations.
constexpr auto finding_names = std::to_array<std::string_view>({
    "other",
    // Frames against the patterns.
    "pattern-mismatch",
    "beyond-black-or-white",
    "unlisted-code-words",
    "contradicting-bits",
    "code-against-phase",
    "phase-origin-off",
    "phase-direction-reversed",
    "no-coordinate-fits",
    "unrelated-modulations",
    "fringe-orders-disagree",
    "coordinate-jumps",
    "better-settings",
    // Frames that were damaged, mixed or lit differently.
    "repeated-frame",
    "partly-repeated-frame",
    "partly-black-frame",
    "frame-without-pattern",
    "mixed-frames",
    "changing-light",
    // Light and camera.
    "too-many-grey-levels",
    "unused-bits",
    "no-modulation",
    "low-modulation",
    "mostly-dark",
    "saturated",
    "clipped",
    "strong-ambient-light",
    "colour-mosaic",
    "nonlinear-light",
    "unproven-response",
    "blind-gamma-refused",
    "excess-noise",
    // Frames against the scanner, and the scanner by itself.
    "geometry-mismatch",
    "depths-beyond-boards",
    "short-baseline",
    "oblique-baseline",
    "off-centre-camera",
    "off-centre-projector",
    "stripes-along-baseline",
    "small-scale",
    "axes-disagree",
    "cameras-disagree",
    "camera-orders-disagree",
    "few-points",
    "cameras-apart",
    // Maps of other programs.
    "shared-map-value",
    "impossible-map-values",
    "light-ends-elsewhere",
    // Calibration.
    "phase-ripple",
    "blurred-print",
    "faint-fringes",
    "saturated-board",
    "uncertain-focal-length",
    "unlit-corners",
    "few-poses",
    "parallel-boards",
    "uncovered-picture",
    "bent-board",
    "stretched-board",
    "wrong-print-size",
    "oblong-projector-pixels",
    "odd-pose",
    "two-rigs",
    "large-camera-rms",
    "large-projector-rms",
    "inaccurate-scanner",
});

constexpr auto cause_names = std::to_array<std::string_view>({
    "unclear",
    // Settings of the scan.
    "frame-order",
    "pattern-settings",
    "axis",
    "bit-depth",
    // The scanner file, and pictures that it is not for.
    "scanner-file",
    "other-rig",
    "picture-size",
    "picture-orientation",
    "rig-moved",
    "depth-range",
    // The response.
    "gamma",
    "needless-response",
    // Capture.
    "repeated-frame",
    "lost-data",
    "dark-projector",
    "out-of-step",
    "flicker",
    "overexposure",
    "underexposure",
    "ambient-light",
    "clipped-pictures",
    "colour-mosaic",
    "blur",
    "noise",
    "rejected-pixels",
    // Maps of other programs.
    "map-unit",
    "invalid-pixels",
    // Calibration.
    "few-poses",
    "few-tilts",
    "board-coverage",
    "board-print",
    "bent-board",
    "moved-board",
    "projector-size",
    "inaccurate-corners",
});

static_assert(finding_names.size() ==
              static_cast<std::size_t>(FindingKind::inaccurate_scanner) + 1);
static_assert(cause_names.size() == static_cast<std::size_t>(CauseKind::inaccurate_corners) + 1);

}  // namespace

std::string_view name_of(FindingKind kind) {
  return finding_names.at(static_cast<std::size_t>(kind));
}

std::string_view name_of(CauseKind kind) {
  return cause_names.at(static_cast<std::size_t>(kind));
}

std::string name_with_unit(const Evidence& evidence) {
  return evidence.unit.empty() ? evidence.name : evidence.name + ", " + evidence.unit;
}

Remedy change_settings(std::string_view verb, std::vector<SettingChange> settings) {
  std::string text(verb);

  for (const auto& [name, value] : settings) {
    if (value.empty() || value == "true") {
      text += fmt::format(" `{}`", name);
    } else if (value == "false") {
      text += fmt::format(" `no_{}`", name);
    } else {
      text += fmt::format(" `{} {}`", name, value);
    }
  }

  return {std::move(text), std::move(settings)};
}

Remedy try_setting(std::string name, std::string value) {
  return change_settings("try", {{std::move(name), std::move(value)}});
}

std::string symptom_of(const Finding& finding) {
  return finding.subject.empty() ? finding.what : finding.subject + ": " + finding.what;
}

std::string causes_of(const Finding& finding) {
  std::string text;
  for (const Cause& cause : finding.causes) text += (text.empty() ? "" : ", or ") + cause.text;
  return text;
}

std::string remedies_of(const Finding& finding) {
  std::string text;
  for (const Remedy& remedy : finding.remedies) text += (text.empty() ? "" : "; or ") + remedy.text;

  if (!finding.remark.empty()) text += (text.empty() ? "" : "; ") + finding.remark;
  return text;
}

std::string text_of(const Finding& finding) {
  std::string numbers;
  for (const Evidence& evidence : finding.evidence) {
    numbers += fmt::format("{}{} = {:.3g}", numbers.empty() ? "" : ", ", name_with_unit(evidence),
                           evidence.value);
  }

  std::string text = symptom_of(finding);
  if (!numbers.empty()) text += fmt::format(" ({})", numbers);

  const std::string causes = causes_of(finding), remedies = remedies_of(finding);
  if (!causes.empty()) text += "; likely " + causes;
  if (!remedies.empty()) text += "; " + remedies;

  return text;
}

bool is_same(const Finding& one, const Finding& other) {
  if (one.kind != other.kind || one.subject != other.subject) return false;
  return one.kind == FindingKind::changing_light || one.frames == other.frames;
}

bool blames(const Finding& finding, CauseKind cause) {
  return !finding.causes.empty() && finding.causes.front().kind == cause;
}

std::vector<Finding> without_cause(std::vector<Finding> findings, CauseKind cause) {
  std::erase_if(findings, [&](const Finding& finding) { return blames(finding, cause); });
  return findings;
}

bool any_wrong(std::span<const Finding> findings) {
  return std::ranges::count(findings, Severity::wrong, &Finding::severity) > 0;
}

std::vector<Finding> gravest_first(std::vector<Finding> findings) {
  std::ranges::stable_sort(findings, std::ranges::greater(), &Finding::severity);
  return findings;
}

}  // namespace slipstream
