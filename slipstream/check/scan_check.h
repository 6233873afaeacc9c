#pragma once

#include <optional>

#include "slipstream/check/finding.h"
#include "slipstream/geometry/scan.h"

namespace slipstream {

/// What findings begin their likely cause with that blame the projector's response, or too much or
/// too little light: for without_cause, where these are told otherwise or do no harm.
inline constexpr std::string_view gamma_is_to_blame = "the projector's gamma";
inline constexpr std::string_view clipping_is_to_blame = "too much light";
inline constexpr std::string_view darkness_is_to_blame = "far too little light";

struct CheckSettings {
  double minimum_modulation = 15;  ///< least of a pixel that becomes a point, grey levels of 255
  /// Whether things may move while the frames are taken: what that does to frames is no finding.
  bool moving = false;
  std::vector<int> order{};  ///< Scan::order, over which advice about the order is given
  /// What is known of the projector's light where no scanner says it.
  PhotometricCalibration photometry{};
};

/// How much the frames of a pixel differ at least by which a scan is judged, grey levels of 255.
/// Darker ones may become points where the settings say so, but are noise to judge by.
double least_range(const CheckSettings& settings);

/// What was found out about a scan.
struct ScanFindings {
  std::vector<Finding> findings;
  /// Where the frames have slipped, so that the cycle begins at another one: frame `order[n]` shows
  /// pattern n. Empty where it does not, or that is not sure.
  std::vector<int> order;
};

/// Whether frames fit the sequence, the scanner and each other, judged by some hundred lit pixels
/// spread over the picture: see docs/reference/scan-validation.md. Without a scanner less can be told. Phases are
/// corrected for the scanner's response, or that of the settings.
ScanFindings check_frames(const FrameViews& frames, const Sequence& sequence,
                          const std::optional<Scanner>& scanner,
                          const CheckSettings& settings = {});

/// The same of what a scan's first camera took; what a further one took is a scan of its own.
ScanFindings check_scan(const Scan& scan, const CheckSettings& settings = {});

/// Whether a scanner looks like one: signatures of files in metres, of devices swapped, of pictures
/// of another size. `whole_pictures`: of the camera, whose middle may be anywhere in one that was
/// cut out of the sensor's.
std::vector<Finding> check_scanner(const Scanner& scanner, bool whole_pictures = true);

/// What is amiss with a scan, and what was done about it.
struct CheckedScan {
  std::vector<Finding> findings;
  std::vector<std::string> repairs;  ///< a line each, for people
};

/// Asks check_scan of each of the scan's cameras; what is told of a further one says so. The frames
/// of a camera that have slipped are put in the order that was found. Of several cameras nothing is
/// told of gamma: they match whatever phase the projector shows.
CheckedScan check_and_repair(Scan& scan, const CheckSettings& settings = {});

/// What is wrong first.
std::vector<Finding> gravest_first(std::vector<Finding> findings);

/// Throws Error, naming the scan and all findings, what is wrong first, where something is wrong.
void require_right(const CheckedScan& checked, const std::string& scan);

/// What is wrong with the scan that a cloud was made of all the same, for the header of its file.
std::vector<std::string> doubts(const std::vector<Finding>& findings);

}  // namespace slipstream
