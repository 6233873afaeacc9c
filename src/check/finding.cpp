#include "slipstream/finding.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace slipstream {
namespace {

/// A kind with its identifier.
template <class Kind>
using Named = std::pair<Kind, std::string_view>;

constexpr std::array named_findings = std::to_array<Named<FindingKind>>({
    {FindingKind::other, "other"},

    // Frames against the patterns.
    {FindingKind::pattern_mismatch, "pattern-mismatch"},
    {FindingKind::beyond_black_or_white, "beyond-black-or-white"},
    {FindingKind::unlisted_code_words, "unlisted-code-words"},
    {FindingKind::contradicting_bits, "contradicting-bits"},
    {FindingKind::code_against_phase, "code-against-phase"},
    {FindingKind::phase_origin_off, "phase-origin-off"},
    {FindingKind::phase_direction_reversed, "phase-direction-reversed"},
    {FindingKind::no_coordinate_fits, "no-coordinate-fits"},
    {FindingKind::unrelated_modulations, "unrelated-modulations"},
    {FindingKind::fringe_orders_disagree, "fringe-orders-disagree"},
    {FindingKind::coordinate_jumps, "coordinate-jumps"},
    {FindingKind::better_settings, "better-settings"},

    // Frames that were damaged, mixed or lit differently.
    {FindingKind::repeated_frame, "repeated-frame"},
    {FindingKind::partly_repeated_frame, "partly-repeated-frame"},
    {FindingKind::partly_black_frame, "partly-black-frame"},
    {FindingKind::frame_without_pattern, "frame-without-pattern"},
    {FindingKind::mixed_frames, "mixed-frames"},
    {FindingKind::changing_light, "changing-light"},

    // Light and camera.
    {FindingKind::too_many_grey_levels, "too-many-grey-levels"},
    {FindingKind::unused_bits, "unused-bits"},
    {FindingKind::no_modulation, "no-modulation"},
    {FindingKind::low_modulation, "low-modulation"},
    {FindingKind::mostly_dark, "mostly-dark"},
    {FindingKind::saturated, "saturated"},
    {FindingKind::clipped, "clipped"},
    {FindingKind::strong_ambient_light, "strong-ambient-light"},
    {FindingKind::colour_mosaic, "colour-mosaic"},
    {FindingKind::nonlinear_light, "nonlinear-light"},
    {FindingKind::unproven_response, "unproven-response"},
    {FindingKind::blind_gamma_refused, "blind-gamma-refused"},
    {FindingKind::excess_noise, "excess-noise"},

    // Frames against the scanner, and the scanner by itself.
    {FindingKind::geometry_mismatch, "geometry-mismatch"},
    {FindingKind::depths_beyond_boards, "depths-beyond-boards"},
    {FindingKind::short_baseline, "short-baseline"},
    {FindingKind::oblique_baseline, "oblique-baseline"},
    {FindingKind::off_centre_camera, "off-centre-camera"},
    {FindingKind::off_centre_projector, "off-centre-projector"},
    {FindingKind::stripes_along_baseline, "stripes-along-baseline"},
    {FindingKind::small_scale, "small-scale"},
    {FindingKind::axes_disagree, "axes-disagree"},
    {FindingKind::cameras_disagree, "cameras-disagree"},
    {FindingKind::camera_orders_disagree, "camera-orders-disagree"},
    {FindingKind::few_points, "few-points"},

    // Maps of other programs.
    {FindingKind::shared_map_value, "shared-map-value"},
    {FindingKind::impossible_map_values, "impossible-map-values"},
    {FindingKind::light_ends_elsewhere, "light-ends-elsewhere"},

    // Calibration.
    {FindingKind::phase_ripple, "phase-ripple"},
    {FindingKind::blurred_print, "blurred-print"},
    {FindingKind::faint_fringes, "faint-fringes"},
    {FindingKind::saturated_board, "saturated-board"},
    {FindingKind::uncertain_focal_length, "uncertain-focal-length"},
    {FindingKind::unlit_corners, "unlit-corners"},
    {FindingKind::few_poses, "few-poses"},
    {FindingKind::parallel_boards, "parallel-boards"},
    {FindingKind::uncovered_picture, "uncovered-picture"},
    {FindingKind::bent_board, "bent-board"},
    {FindingKind::stretched_board, "stretched-board"},
    {FindingKind::wrong_print_size, "wrong-print-size"},
    {FindingKind::oblong_projector_pixels, "oblong-projector-pixels"},
    {FindingKind::odd_pose, "odd-pose"},
    {FindingKind::two_rigs, "two-rigs"},
    {FindingKind::large_camera_rms, "large-camera-rms"},
    {FindingKind::large_projector_rms, "large-projector-rms"},
    {FindingKind::inaccurate_scanner, "inaccurate-scanner"},
});

constexpr std::array named_causes = std::to_array<Named<CauseKind>>({
    {CauseKind::unclear, "unclear"},

    // Settings of the scan.
    {CauseKind::frame_order, "frame-order"},
    {CauseKind::pattern_settings, "pattern-settings"},
    {CauseKind::axis, "axis"},
    {CauseKind::bit_depth, "bit-depth"},

    // The scanner file, and pictures that it is not for.
    {CauseKind::scanner_file, "scanner-file"},
    {CauseKind::other_rig, "other-rig"},
    {CauseKind::picture_size, "picture-size"},
    {CauseKind::picture_orientation, "picture-orientation"},
    {CauseKind::rig_moved, "rig-moved"},
    {CauseKind::depth_range, "depth-range"},

    // The response.
    {CauseKind::gamma, "gamma"},
    {CauseKind::needless_response, "needless-response"},

    // Capture.
    {CauseKind::repeated_frame, "repeated-frame"},
    {CauseKind::lost_data, "lost-data"},
    {CauseKind::dark_projector, "dark-projector"},
    {CauseKind::out_of_step, "out-of-step"},
    {CauseKind::flicker, "flicker"},
    {CauseKind::overexposure, "overexposure"},
    {CauseKind::underexposure, "underexposure"},
    {CauseKind::ambient_light, "ambient-light"},
    {CauseKind::clipped_pictures, "clipped-pictures"},
    {CauseKind::colour_mosaic, "colour-mosaic"},
    {CauseKind::blur, "blur"},
    {CauseKind::noise, "noise"},
    {CauseKind::rejected_pixels, "rejected-pixels"},

    // Maps of other programs.
    {CauseKind::map_unit, "map-unit"},
    {CauseKind::invalid_pixels, "invalid-pixels"},

    // Calibration.
    {CauseKind::few_poses, "few-poses"},
    {CauseKind::few_tilts, "few-tilts"},
    {CauseKind::board_coverage, "board-coverage"},
    {CauseKind::board_print, "board-print"},
    {CauseKind::bent_board, "bent-board"},
    {CauseKind::moved_board, "moved-board"},
    {CauseKind::projector_size, "projector-size"},
    {CauseKind::inaccurate_corners, "inaccurate-corners"},
});

/// Whether each kind stands at its place, so that it can be looked up by its number.
template <class Names>
constexpr bool is_complete(const Names& names, std::size_t count) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (static_cast<std::size_t>(names[i].first) != i) return false;
  }
  return names.size() == count;
}

static_assert(is_complete(named_findings,
                          static_cast<std::size_t>(FindingKind::inaccurate_scanner) + 1));
static_assert(is_complete(named_causes,
                          static_cast<std::size_t>(CauseKind::inaccurate_corners) + 1));

/// The kinds of a table of names.
template <class Kind, std::size_t count>
constexpr std::array<Kind, count> kinds_of(const std::array<Named<Kind>, count>& names) {
  std::array<Kind, count> kinds{};
  for (std::size_t i = 0; i < count; ++i) kinds[i] = names[i].first;
  return kinds;
}

constexpr std::array all_findings = kinds_of(named_findings);
constexpr std::array all_causes = kinds_of(named_causes);

}  // namespace

std::string_view name_of(FindingKind kind) {
  return named_findings.at(static_cast<std::size_t>(kind)).second;
}

std::string_view name_of(CauseKind kind) {
  return named_causes.at(static_cast<std::size_t>(kind)).second;
}

std::span<const FindingKind> finding_kinds() {
  return all_findings;
}

std::span<const CauseKind> cause_kinds() {
  return all_causes;
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
