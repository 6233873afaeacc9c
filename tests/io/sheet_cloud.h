#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slipstream/cloud.h"

namespace slipstream {

/// A bent, textured sheet of 24x16 pixels with a hole.
inline Cloud sheet_cloud() {
  Cloud cloud({24, 16});
  for (int row = 0; row < 16; ++row) {
    for (int column = 0; column < 24; ++column) {
      cloud.intensity(column, row) = static_cast<float>((column * 37 + row * 11) % 256);
      if (std::hypot(column - 9, row - 7) < 3) continue;
      const float u = 0.02F * static_cast<float>(column - 12);
      const float v = 0.02F * static_cast<float>(row - 8);
      const float z = 600 + 40 * u + 300 * u * v;
      cloud.x(column, row) = u * z;
      cloud.y(column, row) = v * z;
      cloud.z(column, row) = z;
      cloud.validity(column, row) = Validity::valid;
    }
  }
  return cloud;
}

/// The sheet, with another colour at each pixel.
inline Cloud coloured_sheet_cloud() {
  Cloud cloud = sheet_cloud();
  cloud.colour = Image<Colour>(cloud.size());
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    cloud.colour(column, row) = {static_cast<std::uint8_t>(10 * column),
                                 static_cast<std::uint8_t>(15 * row),
                                 static_cast<std::uint8_t>(255 - 10 * column)};
  });
  return cloud;
}

/// The colours of the valid points, in the order of the picture.
inline std::vector<Colour> valid_colours(const Cloud& cloud) {
  std::vector<Colour> colours;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    if (cloud.validity.begin()[i] == Validity::valid) colours.push_back(cloud.colour.begin()[i]);
  }
  return colours;
}

}  // namespace slipstream
