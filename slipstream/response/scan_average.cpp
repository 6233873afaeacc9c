#include "slipstream/response/scan_average.h"

#include <algorithm>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

void ScanAverage::add(const Scan& scan, const std::string& name) {
  const Image<std::uint8_t> unclipped = unclipped_mask(scan.frames);
  if (count() == 0) {
    first_name_ = name;
    sequence_ = scan.sequence;
    unclipped_ = unclipped;
  } else if (scan.sequence.strategy != sequence_.strategy) {
    throw Error(fmt::format("{}: another strategy than in {}; scans that are averaged are alike",
                            name, first_name_));
  }
  frames_.add(scan.frames);
  std::transform(unclipped_.begin(), unclipped_.end(), unclipped.begin(), unclipped_.begin(),
                 [](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a & b); });
}

}  // namespace slipstream
