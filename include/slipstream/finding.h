#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace slipstream {

/// How much of a measurement a finding affects.
enum class Severity {
  doubtful,  ///< some points may be wrong: a warning
  wrong,     ///< no point can be right: the scan is refused
};

/// The symptom that a check found. name_of gives the stable identifier of each, in JSON and Python
/// too: "fringe-orders-disagree". docs/reference/findings.md lists them all. Add new ones at the
/// end of their group; never rename one.
enum class FindingKind {
  other,  ///< of a check outside the library; `subject` tells several apart
  // Frames against the patterns.
  pattern_mismatch,
  beyond_black_or_white,
  unlisted_code_words,
  contradicting_bits,
  code_against_phase,
  phase_origin_off,
  phase_direction_reversed,
  no_coordinate_fits,
  unrelated_modulations,
  fringe_orders_disagree,
  coordinate_jumps,
  better_settings,
  // Frames that were damaged, mixed or lit differently.
  repeated_frame,
  partly_repeated_frame,
  partly_black_frame,
  frame_without_pattern,
  mixed_frames,
  changing_light,
  // Light and camera.
  too_many_grey_levels,
  unused_bits,
  no_modulation,
  low_modulation,
  mostly_dark,
  saturated,
  clipped,
  strong_ambient_light,
  colour_mosaic,
  nonlinear_light,
  unproven_response,
  blind_gamma_refused,
  excess_noise,
  // Frames against the scanner, and the scanner by itself.
  geometry_mismatch,
  depths_beyond_boards,
  short_baseline,
  oblique_baseline,
  off_centre_camera,
  off_centre_projector,
  stripes_along_baseline,
  small_scale,
  axes_disagree,
  cameras_disagree,
  camera_orders_disagree,
  few_points,
  cameras_apart,
  // Maps of other programs.
  shared_map_value,
  impossible_map_values,
  light_ends_elsewhere,
  // Calibration.
  phase_ripple,
  blurred_print,
  faint_fringes,
  saturated_board,
  uncertain_focal_length,
  unlit_corners,
  few_poses,
  parallel_boards,
  uncovered_picture,
  bent_board,
  stretched_board,
  wrong_print_size,
  oblong_projector_pixels,
  odd_pose,
  two_rigs,
  large_camera_rms,
  large_projector_rms,
  inaccurate_scanner,
};

/// The likely cause of a finding. Identifiers as for FindingKind: "frame-order".
enum class CauseKind {
  unclear,  ///< one of several broad causes
  // Settings of the scan.
  frame_order,
  pattern_settings,
  axis,
  bit_depth,
  // The scanner file, and pictures that it is not for.
  scanner_file,
  other_rig,
  picture_size,
  picture_orientation,
  rig_moved,
  depth_range,
  // The response.
  gamma,
  needless_response,
  // Capture.
  repeated_frame,
  lost_data,
  dark_projector,
  out_of_step,
  flicker,
  overexposure,
  underexposure,
  ambient_light,
  clipped_pictures,
  colour_mosaic,
  blur,
  noise,
  rejected_pixels,
  // Maps of other programs.
  map_unit,
  invalid_pixels,
  // Calibration.
  few_poses,
  few_tilts,
  board_coverage,
  board_print,
  bent_board,
  moved_board,
  projector_size,
  inaccurate_corners,
};

/// "fringe-orders-disagree"; "frame-order".
std::string_view name_of(FindingKind kind);
std::string_view name_of(CauseKind kind);

/// A measured quantity that supports a finding.
struct Evidence {
  std::string name;  ///< in words: "median depth"
  double value = 0;
  std::string unit{};  ///< "mm"; empty: a number, or a share of 1
  /// Its limit, if there is one: compared by magnitude. Of several, at least one is beyond its own.
  std::optional<double> limit{};

  friend bool operator==(const Evidence&, const Evidence&) = default;
};

/// "median depth, mm".
std::string name_with_unit(const Evidence& evidence);

struct Cause {
  CauseKind kind = CauseKind::unclear;
  std::string text;  ///< in words: "frames 0 to 2 are rotated by one"

  friend bool operator==(const Cause&, const Cause&) = default;
};

/// A setting by name, with the value that it should have. Names are mostly those of Python's
/// keywords and, with dashes, of the program's flags: docs/reference/findings.md has the
/// exceptions.
struct SettingChange {
  std::string name;   ///< "order"
  std::string value;  ///< "2,0,1,3,4,5", "true"; empty: leave the setting out

  friend bool operator==(const SettingChange&, const SettingChange&) = default;
};

/// Something to do about a finding: other settings for the same frames, or something that only a
/// person can do, such as to capture again.
struct Remedy {
  /// In words, settings and operations in backquotes as in Error: "try `order 2,0,1`".
  std::string text;
  std::vector<SettingChange> settings{};  ///< to be changed together; empty: for a person

  friend bool operator==(const Remedy&, const Remedy&) = default;
};

/// "VERB `NAME VALUE` `NAME VALUE`"; a `true` and `false` as `NAME` and `no_NAME`.
Remedy change_settings(std::string_view verb, std::vector<SettingChange> settings);

/// change_settings with "try" and one setting.
Remedy try_setting(std::string name, std::string value);

/// A finding about a scan, a scanner or a calibration.
struct Finding {
  FindingKind kind = FindingKind::other;
  Severity severity = Severity::doubtful;
  std::string what{};  ///< the symptom: "the bands disagree about the phase"
  std::vector<Evidence> evidence{};
  std::vector<Cause> causes{};     ///< likeliest first
  std::vector<Remedy> remedies{};  ///< most promising first; not one for each cause
  std::string remark{};            ///< about the remedies: "all of these fit, so verify the result"
  /// The camera or pose that it is about, if not the whole scan: "camera 2", "board02 along x".
  std::string subject{};
  std::vector<int> frames{};  ///< the frames that it is about, if only some

  friend bool operator==(const Finding&, const Finding&) = default;
};

/// "camera 2: the bands disagree about the phase".
std::string symptom_of(const Finding& finding);

/// "frames 0 and 1 look swapped, or frames 2 and 3 look swapped"; empty if no cause is known.
std::string causes_of(const Finding& finding);

/// "try `order 1,0,2`; or try `order 0,2,1`; all of these fit, so verify the result".
std::string remedies_of(const Finding& finding);

/// One line of text: symptom, evidence, likely causes, remedies.
std::string text_of(const Finding& finding);

/// Whether both report the same symptom of the same thing, perhaps with other numbers. Changing
/// light is the same whichever frames it shows in.
bool is_same(const Finding& one, const Finding& other);

/// Whether the likeliest cause is of this kind.
bool blames(const Finding& finding, CauseKind cause);

/// Drops findings whose likeliest cause is of this kind, such as one that is reported elsewhere.
std::vector<Finding> without_cause(std::vector<Finding> findings, CauseKind cause);

/// True if any finding refuses the scan.
bool any_wrong(std::span<const Finding> findings);

/// Sorts `wrong` before `doubtful`.
std::vector<Finding> gravest_first(std::vector<Finding> findings);

}  // namespace slipstream
