#include "io/pattern_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "frames/colour_channels.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/scan_folder.h"
#include "io/scan_pictures.h"
#include "slipstream/scan_files.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// The grey level in a picture's name: 17 in level_017.png.
double level_in(const fs::path& picture) {
  static constexpr std::string_view prefix = "level_";
  const std::string stem = picture.stem().string();
  const std::string digits = stem.starts_with(prefix) ? stem.substr(prefix.size()) : "";

  const auto level = number_in<std::uint8_t>(digits);
  throw_if(!level || digits.size() > 3,
           "{}: no grey level in its name; name pictures of uniform patterns like level_017.png",
           picture.string());

  return *level / 255.0;
}

/// Mean over the middle quarter of width and height, grey levels of 255.
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

/// Removes the pictures of more patterns that were here before.
void remove_patterns_from(std::size_t n, const fs::path& folder) {
  while (fs::remove(pattern_file(folder, n))) ++n;
}

}  // namespace

fs::path pattern_file(const fs::path& folder, std::size_t n) {
  return folder / fmt::format("pattern_{:02}.png", n);
}

std::vector<fs::path> write_patterns(const fs::path& folder, const PatternSet& patterns,
                                     const Sequence& sequence, int bits,
                                     const std::function<void()>& written) {
  std::vector<fs::path> pictures;

  for (int n = 0; n < patterns.count; ++n) {
    const Image<std::uint16_t> picture = render_pattern(patterns, n, sequence.projector, bits);
    // Only once a pattern could be rendered, so that unsupported bits leave no folder.
    if (n == 0) make_folder(folder);
    const fs::path file = pattern_file(folder, static_cast<std::size_t>(n));

    if (patterns.binary) {
      write_one_bit_image(file, in_8_bits(picture));
    } else if (bits == 8) {
      write_image(file, in_8_bits(picture));
    } else {
      write_image(file, picture);
    }

    pictures.push_back(file);
    written();
  }

  remove_patterns_from(pictures.size(), folder);

  // The marker is a picture, but not a frame of the scan.
  ScanFiles scan{.sequence = sequence, .frames = pictures};
  if (sequence.marker) scan.frames.pop_back();
  write_scan_files(folder / "scan.yaml", scan);

  return pictures;
}

std::vector<fs::path> write_colour_patterns(const fs::path& folder, const PatternSet& patterns,
                                            const Sequence& sequence,
                                            const std::function<void()>& written) {
  require_in_colour(sequence, folder.string());

  const auto write = [&](const PatternSet& set, int first, const fs::path& file) {
    const Image<Colour> picture = picture_in_colour(set, first, sequence.projector);
    if (first == 0) make_folder(folder);
    write_image(file, picture);
  };

  // 1. The patterns, three in each picture.
  std::vector<fs::path> pictures;
  for (int n = 0; n < patterns.count; n += 3) {
    pictures.push_back(pattern_file(folder, pictures.size()));
    write(patterns, n, pictures.back());
    written();
  }
  remove_patterns_from(pictures.size(), folder);

  // 2. The projector's primaries, for calibrating the colours.
  const PatternSet primaries = primary_patterns(patterns.light);
  for (std::size_t i = 0; i < primary_names.size(); ++i) {
    write(primaries, static_cast<int>(3 * i), folder / fmt::format("{}.png", primary_names[i]));
  }

  // 3. The white picture, and the description.
  const fs::path white = folder / "white.png";
  write(white_pattern(patterns.light), 0, white);

  write_scan_files(folder / "scan.yaml",
                   {.sequence = sequence, .frames = pictures, .white = white});

  return pictures;
}

void write_pattern_sheet(const fs::path& file, const PatternSet& patterns, int length) {
  constexpr int height = 16, apart = 4;
  require_ending(file, "picture of patterns", {".png"});

  // Rendered along x, whatever the axis, each pattern is a strip with a gap below.
  PatternSet across = patterns;
  across.axis = Axis::x;
  Image<std::uint8_t> sheet({length, patterns.count * (height + apart) - apart}, 255);

  for (int n = 0; n < patterns.count; ++n) {
    const Image<std::uint8_t> strip = in_8_bits(render_pattern(across, n, {length, height}));
    std::copy(strip.begin(), strip.end(), sheet.row(n * (height + apart)));
  }

  write_image(file, sheet);
}

UniformLevels read_uniform_pictures(const fs::path& folder) {
  UniformLevels levels;
  for (const fs::path& picture : images_in_folder(folder)) {
    // At 98 % of full scale, some pixels are already clipped.
    const double mean = middle_mean(read_frames({picture}).frames);
    throw_if(mean > 0.98 * 255, "{}: saturated (mean {:.0f}, limit 250); shorten the exposure",
             picture.string(), mean);

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
