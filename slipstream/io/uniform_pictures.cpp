#include "slipstream/io/uniform_pictures.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// The grey level in a picture's name: 17 in level_017.png.
double level_in(const fs::path& picture) {
  static constexpr std::string_view prefix = "level_";
  const std::string stem = picture.stem().string();
  const std::string digits = stem.starts_with(prefix) ? stem.substr(prefix.size()) : "";
  const bool number = std::all_of(digits.begin(), digits.end(),
                                  [](unsigned char c) { return std::isdigit(c) != 0; });
  if (digits.empty() || digits.size() > 3 || !number || std::stoi(digits) > 255) {
    throw Error(fmt::format(
        "{}: no grey level in its name; pictures of uniform patterns are named as level_017.png",
        picture.string()));
  }
  return std::stoi(digits) / 255.0;
}

/// Of the middle quarter of its width and height, grey levels of 255.
double middle_mean(const FrameViews& frames) {
  const Size size = frames.size();
  double sum = 0, count = 0;
  frames.visit([&](const auto& views) {
    for (int row = 3 * size.height / 8; row <= 5 * size.height / 8; ++row) {
      for (int column = 3 * size.width / 8; column <= 5 * size.width / 8; ++column) {
        sum += static_cast<double>(views[0](column, row));
        ++count;
      }
    }
  });
  return sum / count * 255 / frames.full_scale();
}

}  // namespace

UniformLevels read_uniform_pictures(const fs::path& folder) {
  UniformLevels levels;
  for (const fs::path& picture : images_in_folder(folder)) {
    const double mean = middle_mean(read_frames({picture}).frames);
    if (mean > 0.98 * 255) {
      throw Error(fmt::format("{}: saturated; expose shorter", picture.string()));
    }
    levels.values.push_back(level_in(picture));
    levels.intensities.push_back(mean);
  }
  return levels;
}

std::vector<fs::path> write_uniform_pictures(const fs::path& folder, Size size, int count) {
  make_folder(folder);
  std::vector<fs::path> written;
  for (int i = 0; i < count; ++i) {
    const auto level = static_cast<std::uint8_t>(std::lround(255.0 * i / (count - 1)));
    written.push_back(folder / fmt::format("level_{:03}.png", level));
    write_image(written.back(), Image<std::uint8_t>(size, level));
  }
  return written;
}

}  // namespace slipstream
