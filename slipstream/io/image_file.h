#pragma once

#include <filesystem>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/base/page.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/height_calibration.h"

namespace slipstream {

/// Whether the file's ending is one of a picture: png, tif, tiff, bmp, pgm.
bool is_image_file(const std::filesystem::path& path);

/// Frames read from files, and what the reader had to say about them, a line each.
struct LoadedFrames {
  FrameSet frames;
  std::vector<std::string> warnings;
};

/// Reads frames: 8- or 16-bit grey, or 64-bit float (unquantised) TIFF. Colour is converted to grey
/// with a warning. `bits`: of the camera, for 16-bit files that hold fewer; 0 where not known.
/// Throws Error, naming the file, when one is missing, truncated, of another size or kind.
LoadedFrames read_frames(const std::vector<std::filesystem::path>& paths, int bits = 0);

/// Reads pictures in colour as frames of their channels, three of each: see colour_channels.h.
/// Throws Error likewise, and where one is grey.
FrameSet read_colour_frames(const std::vector<std::filesystem::path>& paths, int bits = 0);

/// Throws Error unless colours can be written to a file of that ending: png, tif, tiff, bmp.
void require_colour_ending(const std::filesystem::path& path);

/// Writes a grey picture as PNG, TIFF, BMP or PGM by the file's ending. Throws Error for another
/// ending, WorldError when it cannot be written; never leaves half a file.
void write_image(const std::filesystem::path& path, const Image<std::uint8_t>& image);
void write_image(const std::filesystem::path& path, const Image<std::uint16_t>& image);
/// The same for colours; PGM has none.
void write_image(const std::filesystem::path& path, const Image<Colour>& image);
/// As PNG of one bit a pixel, whatever the ending: 0 is dark, any other level bright.
void write_one_bit_image(const std::filesystem::path& path, const Image<std::uint8_t>& image);

/// Writes report.md and the page's pictures into a folder, which is made where it is missing.
void write_page(const std::filesystem::path& folder, const Page& page);

/// A grey picture as the bytes of a PNG file.
std::vector<std::uint8_t> png_file(const Image<std::uint8_t>& image);

/// Throws Error unless maps can be written to a file of that ending: tif, tiff, npy.
void require_map_ending(const std::filesystem::path& path);

/// Writes a map (depth, phase, coordinate, modulation) as TIFF of 32-bit float, or, by the ending
/// npy, as NumPy does; NaN kept.
void write_map(const std::filesystem::path& path, const Image<float>& map);
void write_map(const std::filesystem::path& path, const Image<double>& map);

/// Reads a map that write_map wrote, or one of 64-bit float.
Image<double> read_map(const std::filesystem::path& path);
/// The same, and the levels of a grey picture of 8 or 16 bits.
Image<double> read_levels(const std::filesystem::path& path);

/// A calibration of heights as a NumPy file of 32-bit float: rows x 5 columns, the members of each
/// pixel's HeightCurve one after the other. Throws Error for an ending other than .npy.
void write_height_curves(const std::filesystem::path& path, const Image<HeightCurve>& curves);
/// Throws Error, naming the file, where it is another or its numbers are no calibration's.
Image<HeightCurve> read_height_curves(const std::filesystem::path& path);

/// Writes the frames to those paths in order: 8- or 16-bit pictures, or 64-bit float TIFF for
/// unquantised ones.
void write_frames(const std::vector<std::filesystem::path>& paths, const FrameViews& frames);
/// Three frames, of 8 bits, for each path: a picture in colour.
void write_colour_frames(const std::vector<std::filesystem::path>& paths, const FrameViews& frames);

}  // namespace slipstream
