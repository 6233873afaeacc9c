#include "slipstream/check/scan_check.h"

namespace slipstream {

ScanFindings check_scan(const Scan&, const CheckSettings&) {
  return {};
}

std::vector<Finding> check_scanner(const Scanner&) {
  return {};
}

}  // namespace slipstream
