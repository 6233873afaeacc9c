#include "response/scan_average.h"

#include <algorithm>
#include <functional>

#include "base/throw_if-inl.h"

namespace slipstream {

Image<std::uint8_t> in_both(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  throw_if(a.size() != b.size(),
           "the scans have different sizes; expected scans of one static scene");

  Image<std::uint8_t> both = a;
  std::ranges::transform(both, b, both.begin(), std::bit_and<std::uint8_t>());

  return both;
}

void ScanAverage::add(const Scan& scan, const std::string& name) {
  const Image<std::uint8_t> of_scan = unclipped_mask(scan.frames);

  if (frames.count() == 0) {
    first_name = name;
    sequence = scan.sequence;
    unclipped = Image<std::uint8_t>(of_scan.size(), 1);
  }

  throw_if(scan.sequence.strategy != sequence.strategy,
           "{}: strategy differs from {}; averaged scans must match", name, first_name);

  frames.add(scan.frames);
  unclipped = in_both(unclipped, of_scan);
}

}  // namespace slipstream
