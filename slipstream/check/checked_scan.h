#pragma once

#include <string>
#include <vector>

#include "slipstream/check/scan_check.h"

namespace slipstream {

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
