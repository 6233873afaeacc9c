#pragma once

#include <cstdint>
#include <filesystem>

#include "io/image_file.h"
#include "slipstream/image.h"

namespace slipstream {

/// Reads an 8- or 16-bit grey picture without scaling.
inline Image<std::uint16_t> read_grey_image(const std::filesystem::path& path) {
  return read_frames({path}).frames.visit([](const auto& views) {
    Image<std::uint16_t> grey({views[0].width(), views[0].height()});
    for (int row = 0; row < grey.height(); ++row) {
      for (int column = 0; column < grey.width(); ++column) {
        grey(column, row) = static_cast<std::uint16_t>(views[0](column, row));
      }
    }
    return grey;
  });
}

}  // namespace slipstream
