#pragma once

#include <filesystem>
#include <vector>

#include "slipstream/base/size.h"

namespace slipstream {

/// What a camera saw of uniform patterns.
struct UniformLevels {
  std::vector<double> values{};       ///< of the patterns, [0, 1]
  std::vector<double> intensities{};  ///< grey levels of 255
};

/// The pictures of uniform patterns in a folder, each named by its grey level of 255, as
/// level_017.png: the mean over the middle of each, where the light is even. Throws Error where one
/// has no level in its name or is saturated.
UniformLevels read_uniform_pictures(const std::filesystem::path& folder);

/// Writes `count` pictures, 2 to 256, of that size and of one grey level each, from 0 to 255 in
/// even steps, into a folder, which is made, under such names. Returns them.
std::vector<std::filesystem::path> write_uniform_pictures(const std::filesystem::path& folder,
                                                          Size size, int count);

}  // namespace slipstream
