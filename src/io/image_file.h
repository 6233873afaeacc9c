#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/page.h"
#include "geometry/height_calibration.h"
#include "io/frame_pictures.h"
#include "slipstream/frame_set.h"
#include "slipstream/image.h"

namespace slipstream {

/// Whether the file's ending is png, tif, tiff, bmp or pgm.
bool is_image_file(const std::filesystem::path& path);

/// Whether the file's ending is jpg or jpeg.
bool is_jpeg_file(const std::filesystem::path& path);

/// The paths, with each TIFF file of several pages replaced by FILE[0], FILE[1] and so on: one for
/// each of its pictures, which all functions below read. Unreadable files stay; reading reports
/// why. Throws Error for a file of too many pages.
std::vector<std::filesystem::path> with_pages(const std::vector<std::filesystem::path>& paths);

/// The file that has the page FILE[N]; any other path unchanged.
std::filesystem::path file_of_page(const std::filesystem::path& path);

/// Throws Error unless the ending supports colour: png, tif, tiff, bmp.
void require_colour_ending(const std::filesystem::path& path);

/// Writes a grey picture as PNG, TIFF, BMP or PGM by the file's ending. Throws Error for another
/// ending, WorldError if it cannot be written; never leaves a partial file.
void write_image(const std::filesystem::path& path, const Image<std::uint8_t>& image);
void write_image(const std::filesystem::path& path, const Image<std::uint16_t>& image);

/// The same in colour; not as PGM.
void write_image(const std::filesystem::path& path, const Image<Colour>& image);

/// Writes a PNG with one bit per pixel, whatever the ending: 0 is dark, any other level bright.
void write_one_bit_image(const std::filesystem::path& path, const Image<std::uint8_t>& image);

/// Whether the pictures of a page that have pixels are also written as files beside it.
enum class PageFiles { with_pictures, page_alone };

/// Writes a page, .html, with its PNG pictures inside, and those with pixels also beside it unless
/// `files` says otherwise; creates its folder if missing. The files of the others are there
/// already.
void write_page(const std::filesystem::path& path, const Page& page,
                PageFiles files = PageFiles::with_pictures);

/// Throws Error unless the ending supports maps: tif, tiff, npy.
void require_map_ending(const std::filesystem::path& path);

/// Writes a map (depth, phase, coordinate, modulation) as 32-bit float TIFF, or as a NumPy file for
/// the ending npy. Preserves NaN.
void write_map(const std::filesystem::path& path, const Image<float>& map);
void write_map(const std::filesystem::path& path, const Image<double>& map);

/// Reads a map by write_map, or one of 64-bit float.
Image<double> read_map(const std::filesystem::path& path);

/// The same; also accepts a grey picture of 8 or 16 bits, but no JPEG.
Image<double> read_levels(const std::filesystem::path& path);

/// Writes a height calibration as a NumPy file of 32-bit float: rows x 5 columns, the consecutive
/// members of each pixel's HeightCurve. Throws Error for an ending other than .npy.
void write_height_curves(const std::filesystem::path& path, const Image<HeightCurve>& curves);

/// Throws Error with the file's name if it is malformed or not a valid calibration.
Image<HeightCurve> read_height_curves(const std::filesystem::path& path);

/// Writes the frames to `paths` in order: 8- or 16-bit pictures, or 64-bit float TIFF if
/// unquantised.
void write_frames(const std::vector<std::filesystem::path>& paths, const FrameViews& frames);

/// Writes three 8-bit frames per path as a colour picture.
void write_colour_frames(const std::vector<std::filesystem::path>& paths, const FrameViews& frames);

}  // namespace slipstream
