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
  std::vector<float> quarters;  ///< distance of w from the start, quarters of a period
};

/// Matches the pixels band by band, from few periods to many.
void match_pixels(const EpipolarLines& lines, const CameraPhases& first, const CameraPhases& second,
                  const BandSearch& bands, PixelMatches& matches);

/// How far the phases of two cameras differ at one point, or a sum over up to 255 points.
struct Disagreement {
  static constexpr float step = 1 / 4096.0F;
  static constexpr std::int32_t one_pixel = 1 << 24;

  explicit Disagreement(std::uint32_t votes)
      : sum(step * static_cast<float>(static_cast<std::int32_t>(votes % one_pixel))),
        seen(static_cast<float>(static_cast<std::int32_t>(votes / one_pixel))) {}

  float sum;   ///< of 1 - cos of the difference
  float seen;  ///< points that the second camera sees
};

/// Points of pixels of the first camera at coordinates of the projector, and the phase that the
/// second camera sees there.
struct PointPhases {
  std::vector<std::int32_t> pixels{};  ///< index in the picture
  std::vector<float> coordinates{};    ///< of each pixel's first point
  std::vector<std::int32_t> counts{};  ///< of each pixel's points, at most `most`
  float step = 0;                      ///< of the coordinate, to the pixel's next point
  int most = 0;

  /// `most` of each pixel, see Disagreement: in the low bits 1 - cos of the difference between the
  /// cameras' phases of the first band, in the high ones 1. 0 where the second camera does not see
  /// the point, or beyond the depths.
  std::vector<std::uint32_t> votes{};
};

/// `depths`: in the frame of the first camera, or of the second if `of_other`.
void compare_phases(const EpipolarLines& lines, const CameraPhases& first,
                    const CameraPhases& second, const DepthRange& depths, bool of_other,
                    PointPhases& points);

}  // namespace slipstream
