#include "slipstream/frames/reel.h"

#include <numeric>
#include <utility>

namespace slipstream {

Reel reel_of(std::vector<Frame> frames) {
  std::vector<std::size_t> order(frames.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  return {.frames = std::move(frames), .order = std::move(order)};
}

}  // namespace slipstream
