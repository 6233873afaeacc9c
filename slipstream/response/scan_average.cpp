#include "slipstream/response/scan_average.h"

#include <algorithm>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

Image<std::uint8_t> in_both(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  if (a.size() != b.size()) {
    throw Error("the scans are of different sizes; they are to be of one unmoved scene");
  }
  Image<std::uint8_t> both = a;
  std::transform(both.begin(), both.end(), b.begin(), both.begin(),
                 [](std::uint8_t x, std::uint8_t y) { return static_cast<std::uint8_t>(x & y); });
  return both;
}

void ScanAverage::add(const Scan& scan, const std::string& name) {
  const Image<std::uint8_t> unclipped = unclipped_mask(scan.frames);
  if (count() == 0) {
    first_name_ = name;
    sequence_ = scan.sequence;
    unclipped_ = Image<std::uint8_t>(unclipped.size(), 1);
  } else if (scan.sequence.strategy != sequence_.strategy) {
    throw Error(fmt::format("{}: another strategy than in {}; scans that are averaged are alike",
                            name, first_name_));
  }
  frames_.add(scan.frames);
  unclipped_ = in_both(unclipped_, unclipped);
}

}  // namespace slipstream
