#include "slipstream/publish/detail/cloud_block.h"

#include <array>
#include <cstring>

namespace slipstream {
namespace {

template <class Value, class ValueAt>
void append_values(std::vector<std::uint8_t>& bytes, const Rectangle& region, std::size_t each,
                   ValueAt value_at) {
  bytes.resize(static_cast<std::size_t>(region.size.width) *
               static_cast<std::size_t>(region.size.height) * each * sizeof(Value));
  std::uint8_t* to = bytes.data();
  for (int row = region.y; row < region.y + region.size.height; ++row) {
    for (int column = region.x; column < region.x + region.size.width; ++column) {
      for (std::size_t i = 0; i < each; ++i, to += sizeof(Value)) {
        const Value value = value_at(column, row, i);
        std::memcpy(to, &value, sizeof value);
      }
    }
  }
}

}  // namespace

void write_part(const Cloud& cloud, const Rectangle& region, const Packing& packing,
                GigePart& part) {
  switch (part.pixels) {
    case GigePixels::mono8:
      return append_values<std::uint8_t>(part.bytes, region, 1, [&](int column, int row, auto) {
        return grey_level(cloud.intensity(column, row));
      });
    case GigePixels::confidence8:
      return append_values<std::uint8_t>(part.bytes, region, 1, [&](int column, int row, auto) {
        return cloud.validity(column, row) == Validity::valid ? std::uint8_t{255} : std::uint8_t{0};
      });
    case GigePixels::coord3d_c16:
      return append_values<std::uint16_t>(part.bytes, region, 1, [&](int column, int row, auto) {
        return packing.depth(cloud.z(column, row));
      });
    case GigePixels::coord3d_c32f:
      return append_values<float>(part.bytes, region, 1,
                                  [&](int column, int row, auto) { return cloud.z(column, row); });
    case GigePixels::coord3d_abc32f: {
      const std::array axes{&cloud.x, &cloud.y, &cloud.z};
      return append_values<float>(part.bytes, region, 3, [&](int column, int row, std::size_t i) {
        return (*axes[i])(column, row);
      });
    }
  }
}

}  // namespace slipstream
