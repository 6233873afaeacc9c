#include "slipstream/io/pattern_pictures.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>

#include "slipstream/codes/pattern_in_8_bits.h"
#include "slipstream/codes/primaries.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/io/file.h"
#include "slipstream/io/folder_sink.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream {
namespace fs = std::filesystem;

std::vector<fs::path> write_patterns(const fs::path& folder, const PatternSet& patterns,
                                     const Sequence& sequence, int bits,
                                     const std::function<void()>& written) {
  std::vector<fs::path> pictures;
  for (int n = 0; n < patterns.count; ++n) {
    const Image<std::uint16_t> picture = render_pattern(patterns, n, sequence.projector, bits);
    if (n == 0) make_folder(folder);
    const fs::path file = pattern_file(folder, static_cast<std::size_t>(n));
    if (patterns.binary) {
      write_one_bit_image(file, in_8_bits(picture));
    } else {
      bits == 8 ? write_image(file, in_8_bits(picture)) : write_image(file, picture);
    }
    pictures.push_back(file);
    written();
  }
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
  std::vector<fs::path> pictures;
  for (int n = 0; n < patterns.count; n += 3) {
    pictures.push_back(pattern_file(folder, pictures.size()));
    write(patterns, n, pictures.back());
    written();
  }
  const PatternSet primaries = primary_patterns(patterns.light);
  for (std::size_t i = 0; i < primary_names.size(); ++i) {
    write(primaries, static_cast<int>(3 * i), folder / fmt::format("{}.png", primary_names[i]));
  }
  const fs::path white = folder / "white.png";
  write(white_pattern(patterns.light), 0, white);
  write_scan_files(folder / "scan.yaml",
                   {.sequence = sequence, .frames = pictures, .white = white});
  return pictures;
}

void write_pattern_sheet(const fs::path& file, const PatternSet& patterns, int length) {
  constexpr int height = 16, apart = 4;
  require_ending(file, "picture of patterns", {".png"});
  PatternSet across = patterns;
  across.axis = Axis::x;
  Image<std::uint8_t> sheet({length, patterns.count * (height + apart) - apart}, 255);
  for (int n = 0; n < patterns.count; ++n) {
    const Image<std::uint8_t> strip = in_8_bits(render_pattern(across, n, {length, height}));
    std::copy(strip.begin(), strip.end(), sheet.row(n * (height + apart)));
  }
  write_image(file, sheet);
}

}  // namespace slipstream
