#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/error.h"
#include "slipstream/finding.h"
#include "slipstream/gamma.h"
#include "slipstream/scan.h"

namespace slipstream {

struct CheckSettings {
  double minimum_modulation = 15;  ///< of a pixel that becomes a point, grey levels of 255
  /// Whether the scene may move, as with Sequence::motion: its effects are then not reported.
  bool moving = false;
  std::vector<int> order{};  ///< Scan::order; advice about the order is relative to it
  /// Photometric calibration, used without a scanner.
  PhotometricCalibration photometry{};
  std::optional<BlindGamma> blind{};  ///< the blind estimate, if requested: warns if refused
};

/// Minimum difference between the frames of a pixel that the check uses, grey levels of 255.
/// Darker pixels may become points if the settings allow, but are too noisy for the check.
double least_range(const CheckSettings& settings);

struct ScanFindings {
  std::vector<Finding> findings;
  /// Set if the cycle certainly begins at another frame: frame `order[n]` shows pattern n.
  std::vector<int> order;
  double median_depth = 0;  ///< mm; 0 without a scanner
};

/// Checks that the frames fit the sequence, the scanner and each other, using several hundred lit
/// pixels spread over the picture: see docs/reference/scan-validation.md. Finds less without a
/// scanner. Corrects phases for the response in the scanner, or in the settings. `sequence`: of
/// merged frames, see merged_sequence. Throws Error if it has another number of frames.
ScanFindings check_frames(const FrameViews& frames, const Sequence& sequence,
                          const std::optional<Scanner>& scanner,
                          const CheckSettings& settings = {});

/// check_frames for the first camera of a merged scan. Each further camera is a scan of its own.
ScanFindings check_scan(const Scan& scan, const CheckSettings& settings = {});

/// Diagnostics of a scan, and the repairs made.
struct CheckedScan {
  std::vector<Finding> findings{};
  std::vector<std::string> repairs{};  ///< one line of text each
  double median_depth = 0;             ///< of the first camera, mm; 0 without a scanner
};

/// Runs check_scan for each camera of the scan; texts about a further one name it. Puts slipped
/// frames in the right order. With several cameras, omits gamma: matching needs only that they
/// record the same phase.
CheckedScan check_and_repair(Scan& scan, const CheckSettings& settings = {});

/// The error of a scan that is refused.
class RefusedScan : public Error {
 public:
  RefusedScan(std::string message, std::vector<Finding> findings)
      : Error(std::move(message)), findings_(std::move(findings)) {}

  /// All diagnostics of the scan, gravest first.
  [[nodiscard]] const std::vector<Finding>& findings() const { return findings_; }

 private:
  std::vector<Finding> findings_;
};

/// Throws RefusedScan with all diagnostics if any is `wrong`. Its message has the scan's name and
/// the diagnostics. With `from`, looks only at those from this one on, as earlier ones are known.
void require_right(const CheckedScan& checked, const std::string& scan, std::size_t from = 0);

/// Header lines for a cloud file that was made although its scan was refused.
std::vector<std::string> doubts(const std::vector<Finding>& findings);

/// Two cameras agree nowhere with the phase's origin as the strategy has it, and they do if this is
/// added to the measured phase, rad.
Finding wrong_origin(const Strategy& strategy, double phase_shift);

}  // namespace slipstream
