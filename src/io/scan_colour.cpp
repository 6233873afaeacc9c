#include "io/scan_colour.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/throw_if-inl.h"
#include "geometry/rotation.h"
#include "io/file.h"
#include "io/frame_pictures.h"
#include "io/scan_pictures.h"
#include "slipstream/layout.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"

namespace slipstream {
namespace {

/// The camera of colour_scanner, which is calibrated with the scan's camera or its projector.
ColourCamera colour_camera_of(const ScanFiles& files, Image<Colour> picture) {
  const std::filesystem::path& file = *files.colour_scanner;
  ColourCamera camera{.picture = std::move(picture)};

  if (is_camera_pair(file, false)) {
    const Scanner pair = read_camera_pair(file);
    camera.lens = pair.projector;
    camera.pose = pose_from(pair.rotation, pair.translation);
  } else {
    throw_if(!files.scanner, "{}: colour_scanner needs the scan's own scanner file",
             files.path.string());
    const Scanner own = read_scanner(*files.scanner), other = read_scanner(file);
    camera.lens = other.camera;
    camera.pose = pose_from(other.rotation, other.translation).inverse() *
                  pose_from(own.rotation, own.translation);
  }

  throw_if(camera.lens.size.width > 0 && camera.lens.size != camera.picture.size(),
           "{}: the camera of {} takes {} pixels, but the picture `colour` has {}",
           files.path.string(), file.string(), text_of(camera.lens.size),
           text_of(camera.picture.size()));
  return camera;
}

}  // namespace

std::vector<bool> frames_of_colour(const Sequence& sequence) {
  // 1. Frames of one exposure along the first axis.
  std::vector<int> frames = measuring_frames(sequence.strategy.layout());
  const int count = frame_count(sequence.strategy);
  if (frames.empty()) {
    frames.resize(static_cast<std::size_t>(count));
    std::iota(frames.begin(), frames.end(), 0);
  }

  // 2. The place of the shortest exposure, which saturates least.
  const std::vector<double>& times = sequence.exposures;
  const auto shortest = static_cast<int>(std::ranges::min_element(times) - times.begin());
  const int first = shortest * (frame_count(sequence) / static_cast<int>(times.size()));

  std::vector<bool> of_colour(static_cast<std::size_t>(first + count), false);
  for (const int n : frames) of_colour[static_cast<std::size_t>(first + n)] = true;
  return of_colour;
}

namespace {

/// The colours of a scan's pixels, not balanced: of ScanFiles::colour, else of the `white` picture
/// of a scan in colour, else `mean`, of its frames. Empty if all are. Throws Error with the file's
/// name if a picture cannot be read, or shows no colours.
Image<ColourLevels> levels_of_colour(const ScanFiles& files, const FrameSet& white,
                                     Image<ColourLevels> mean) {
  // 1. Pictures for the purpose: one in colour, or a grey one in each of three lights.
  if (files.colour.size() == 1) {
    LoadedFrames loaded = read_frames(files.colour, {.bits = files.bits,
                                                     .channel = GreyChannel::grey,
                                                     .mosaic = files.mosaic,
                                                     .of_colour = {true}});
    const std::string path = files.colour.front().string();
    throw_if(loaded.lossy > 0,
             "{}: `colour` is a JPEG, whose colours are not read; use PNG, TIFF or BMP", path);
    throw_if(loaded.colour.empty(),
             "{}: `colour` is a grey picture; name one in colour, or three in red, green and blue "
             "light",
             path);
    return std::move(loaded.colour);
  }
  if (!files.colour.empty()) return colour_levels(read_frames(files.colour, files.bits).frames);

  // 2. The channels of a white picture, or the frames.
  return white.count() == 3 ? colour_levels(white) : std::move(mean);
}

}  // namespace

void add_colour(Scan& scan, const ScanFiles& files, const FrameSet& white, Image<ColourLevels> mean,
                const std::optional<WhiteBalance>& known) {
  throw_if(files.colour_scanner && files.colour.empty(),
           "{}: colour_scanner is of the camera that took the picture `colour`, which is missing",
           files.path.string());
  const Image<ColourLevels> levels = levels_of_colour(files, white, std::move(mean));
  const std::string path = files.path.string();
  throw_if(files.grey_patch && levels.empty(), "{}: `grey_patch`: its pictures have no colour",
           path);
  if (levels.empty()) return;

  // Another camera has its own white balance.
  WhiteBalance balance = known.value_or(WhiteBalance{1, 1, 1});
  if (files.colour_scanner) {
    balance = read_photometric_calibration(*files.colour_scanner)
                  .white_balance.value_or(WhiteBalance{1, 1, 1});
  }
  if (files.grey_patch) {
    balance = naming(path, [&] { return white_balance(levels, *files.grey_patch); });
  }
  if (files.colour_scanner) {
    scan.colour_camera = colour_camera_of(files, balanced(levels, balance));
    return;
  }

  throw_if(levels.size() != scan.frames.size(),
           "{}: the picture of its colours is {}, its frames {}", path, text_of(levels.size()),
           text_of(scan.frames.size()));
  scan.colour = balanced(levels, balance);
}

WhiteBalance white_balance_of(const ScanFiles& files) {
  const std::string path = files.path.string();
  throw_if(!files.grey_patch, "`grey_patch` is missing: name a place that is grey or white");
  throw_if(files.recording != nullptr, "{}: a recording holds no colours; name a scan folder",
           path);

  FrameSet white;
  Image<ColourLevels> mean;
  if (files.white) {
    white = read_colour_frames({*files.white}, files.bits);
  } else if (files.colour.empty()) {
    mean = read_frames(pattern_pictures(files, frame_count(files.sequence)),
                       {.bits = files.bits,
                        .channel = files.channel,
                        .mosaic = files.mosaic,
                        .of_colour = frames_of_colour(files.sequence)})
               .colour;
  }

  const Image<ColourLevels> levels = levels_of_colour(files, white, std::move(mean));
  throw_if(levels.empty(), "{}: its pictures have no colour", path);
  return naming(path, [&] { return white_balance(levels, *files.grey_patch); });
}

}  // namespace slipstream
