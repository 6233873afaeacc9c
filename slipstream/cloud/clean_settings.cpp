#include "slipstream/cloud/clean_settings.h"

#include <cmath>
#include <cstddef>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

void require(bool holds, std::string_view name, double value, std::string_view range) {
  if (!holds) throw Error(fmt::format("{} {} is out of range; {}", name, value, range));
}

}  // namespace

void require_valid(const CleanSettings& settings) {
  constexpr int widest_window = 10;
  if (settings.largest_sigma) {
    require(*settings.largest_sigma > 0, "largest sigma", *settings.largest_sigma,
            "more than 0 mm");
  }
  require(settings.smallest_component >= 0, "smallest component", settings.smallest_component,
          "0 pixels or more");
  require(settings.widest_gap >= 0, "widest gap", settings.widest_gap, "0 pixels or more");
  require(settings.smoothing >= 0 && settings.smoothing <= widest_window, "smoothing",
          settings.smoothing, "0 to 10 pixels");
  if (settings.box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      require(settings.box->largest[axis] > settings.box->least[axis], "end of the box",
              settings.box->largest[axis], "more than where it begins");
    }
  }
  if (settings.outline.size() == 1) throw Error("an outline needs two corners or more");
  for (const PictureCorner& corner : settings.outline) {
    require(std::isfinite(corner.column) && std::isfinite(corner.row), "corner of the outline",
            corner.column + corner.row, "it must be finite");
  }
}

}  // namespace slipstream
