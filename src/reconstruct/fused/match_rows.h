#pragma once

#include <cstdint>
#include <vector>

#include "reconstruct/band_search.h"
#include "reconstruct/epipolar_tables.h"

// Two cameras' phases along epipolar lines, several pixels at a time, compiled for each vector
// target.
namespace slipstream {

/// Pixels of the first camera, and where the second sees them under the same phase.
struct PixelMatches {
  std::vector<std::int32_t> pixels;  ///< index in the picture
  std::vector<float> coordinates;    ///< of the projector: the start of the search

  std::vector<float> w;      ///< inverse depth 1 / Z, 1 / mm; NaN without a match
  std::vector<float> x, y;   ///< pixel of the second camera
  std::vector<float> speed;  ///< length of the pixel's change over w
  /// Change of the phase along the line, rad per pixel of the second camera.
  std::vector<float> slope;
};

/// Matches the pixels band by band, from few periods to many.
void match_pixels(const EpipolarLines& lines, const CameraPhases& first, const CameraPhases& second,
                  const BandSearch& bands, PixelMatches& matches);

/// Points of pixels of the first camera at coordinates of the projector, and the phase that the
/// second camera sees there.
struct PointPhases {
  std::vector<std::int32_t> pixels{};  ///< index in the picture
  std::vector<float> coordinates{};    ///< of each pixel's first point
  float step = 0;                      ///< of the coordinate, to the pixel's next point
  int points = 0;                      ///< of each pixel

  /// 1 - cos of the difference between the cameras' phases of the first band: of all first points,
  /// then of all second ones. NaN where the second camera does not see the point, or beyond the
  /// depths.
  std::vector<float> apart{};
};

/// `depths`: in the frame of the first camera, or of the second if `of_other`.
void compare_phases(const EpipolarLines& lines, const CameraPhases& first,
                    const CameraPhases& second, const DepthRange& depths, bool of_other,
                    PointPhases& points);

}  // namespace slipstream
