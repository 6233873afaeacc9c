#include "slipstream/camera/camera_region.h"

#include <charconv>

#include "slipstream/image/size_text.h"

namespace slipstream {

std::optional<CameraRegion> region_of_text(std::string_view text) {
  const std::size_t plus = text.find('+');
  const std::optional<Size> size = size_of_text(text.substr(0, plus));
  if (!size) return std::nullopt;
  CameraRegion region{.size = *size};
  if (plus == std::string_view::npos) return region;
  const char* const end = text.data() + text.size();
  const auto [middle, bad_x] = std::from_chars(text.data() + plus + 1, end, region.x);
  if (bad_x != std::errc() || middle == end || *middle != '+') return std::nullopt;
  const auto [rest, bad_y] = std::from_chars(middle + 1, end, region.y);
  const bool good = bad_y == std::errc() && rest == end && region.x >= 0 && region.y >= 0;
  return good ? std::optional(region) : std::nullopt;
}

}  // namespace slipstream
