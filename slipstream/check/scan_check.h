#pragma once

#include <optional>
#include <vector>

#include "slipstream/check/finding.h"
#include "slipstream/scan/scan.h"

namespace slipstream {

struct CheckSettings {
  /// Least modulation of a pixel that becomes a point, grey levels of the frames; by default 15 of
  /// 255.
  std::optional<double> minimum_modulation{};
};

/// What was found out about a scan.
struct ScanFindings {
  std::vector<Finding> findings;
  /// Where the frames have slipped, so that the cycle begins at another one: frame `order[n]` shows
  /// pattern n. Empty where it does not, or that is not sure.
  std::vector<int> order;
};

/// Whether the frames fit the sequence, the scanner and each other, judged by a few thousand pixels
/// spread over the picture: see docs/trust.md. Without a scanner less can be told. Nothing is
/// thrown for a scan that can be reconstructed.
ScanFindings check_scan(const Scan& scan, const CheckSettings& settings = {});

/// Whether a scanner looks like one: signatures of files in metres, of devices swapped, of pictures
/// of another size.
std::vector<Finding> check_scanner(const Scanner& scanner);

}  // namespace slipstream
