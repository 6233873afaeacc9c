#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "frames/point_colours.h"
#include "slipstream/frame_set.h"
#include "slipstream/scan_files.h"

namespace slipstream {

/// Frames read from files, and warnings, one line each.
struct LoadedFrames {
  FrameSet frames;
  std::vector<std::string> warnings;
  int lossy = 0;                 ///< how many of the pictures are JPEG; no warning tells of them
  Image<ColourLevels> colour{};  ///< mean of FrameReading::of_colour; empty if they are grey
};

/// How pictures become frames.
struct FrameReading {
  int bits = 0;  ///< of the camera, for 16-bit files with fewer bits; 0: as the files declare
  GreyChannel channel = GreyChannel::by_light;  ///< of colour pictures
  std::string mosaic{};  ///< of raw pictures, as in ScanFiles; those of real numbers are refused
  std::vector<bool> of_colour{};  ///< which pictures show the colours; empty: none
};

/// Reads frames: 8- or 16-bit grey, or TIFF of float (unquantised), whose levels are of 255, of
/// `bits` or, with a warning, shares of 1. Converts colour to grey by `channel`, with a warning
/// unless it was chosen; of JPEG reads the luminance. Grey is at full scale where a colour is.
/// Throws Error with the file's name if one is missing, truncated, of another size or kind, or has
/// several pages.
LoadedFrames read_frames(const std::vector<std::filesystem::path>& paths,
                         const FrameReading& reading);
LoadedFrames read_frames(const std::vector<std::filesystem::path>& paths, int bits = 0,
                         GreyChannel channel = GreyChannel::by_light);

/// Reads colour pictures as frames, three channels each: see colour_channels.h. Throws Error as
/// read_frames, and for a grey picture or a JPEG.
FrameSet read_colour_frames(const std::vector<std::filesystem::path>& paths, int bits = 0);

}  // namespace slipstream
