#include "slipstream/reconstruct/multiplexed_picture.h"

namespace slipstream {

void MultiplexedPicture::prepare(Size size) {
  if (flags_.size() == size) return;
  coordinate_ = Image<float>({size.width + 2 * side, size.height + 2 * margin},
                             std::numeric_limits<float>::quiet_NaN());
  flags_ = Image<std::uint8_t>(size);
  shift_ = Image<std::int16_t>(size);
}

}  // namespace slipstream
