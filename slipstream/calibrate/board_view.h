#pragma once

#include <string>

#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/geometry/scan.h"

namespace slipstream {

/// What the frames of one scan of a board say about how they were taken, by a few thousand of its
/// pixels that are bright and not saturated.
struct FringeSigns {
  double saturated = 0;  ///< share of the board's pixels that some frame shows at full scale
  int steps = 0;         ///< N of the band that measures; 0 where that is no run of steps
  double period = 0;  ///< of a fringe of that band, projector pixels; 0 where nothing was measured
  /// Amplitude, rad, of the error of that band's phase that repeats N times in each fringe, against
  /// the smooth course of the phase over a flat board; and its standard deviation.
  double ripple = 0;
  double ripple_deviation = 0;
  /// Modulation of the finest band over that of the coarsest, each by its share: 1 where fringes
  /// are sharp, less where they are blurred.
  double contrast = 1;
};

/// `corners`: of the board, pixels. Phases are corrected by what `corrections` has for their N.
/// Nothing is measured where too few pixels are bright. The frames must be the layout's.
FringeSigns fringe_signs(const Scan& scan, const PixelPlaces& corners, double minimum_modulation,
                         const PhaseCorrections& corrections);

/// Whether a ripple is one: larger than noise and than what does no harm.
bool has_ripple(const FringeSigns& signs);

/// How soft the edges of a board's print are in a picture: the standard deviation of the Gaussian
/// that would blur them so, pixels, the median of all edges; and the same in spacings of the board.
struct EdgeSoftness {
  double pixels = 0;
  double spacings = 0;
};

/// Whether that is too soft: more than an eighth of a spacing, so that less than half of it is flat
/// and corners move with what is beside them, and more than the one and a half pixels of the pixels
/// themselves.
bool is_soft(const EdgeSoftness& edges);

/// `places` and `corners`: which places of the board are where in the picture. Zero where no two
/// neighbours are seen.
EdgeSoftness edge_softness(const Image<float>& picture, const CalibrationBoard& board,
                           const std::vector<int>& places, const PixelPlaces& corners);

/// All of it of one pose.
struct CaptureSigns {
  FringeSigns x{};
  FringeSigns y{};
  EdgeSoftness edges{};
};

/// One pose of the board: where camera and projector see its corners.
struct BoardView {
  std::string name;         ///< of the pose's folder
  std::vector<int> places;  ///< which corner of the board each is
  PixelPlaces camera;       ///< pixels
  PixelPlaces projector;    ///< pixels; NaN where it could not be told
  /// d projector / d camera: a corner that the camera sees a little off was looked for in the
  /// projector's picture a little off too, by as much as this makes of it. Empty, or zero, where
  /// the projector pixels are independent of the camera's.
  std::vector<Eigen::Matrix2d> slopes{};
  CaptureSigns signs{};  ///< how its frames were taken; nothing where there were none
};

using BoardViews = std::vector<BoardView>;

enum class Device { camera, projector };

/// Where that device sees the corners.
inline const PixelPlaces& corners_of(const BoardView& view, Device device) {
  return device == Device::camera ? view.camera : view.projector;
}

/// `slopes` of a corner, zero where there is none.
inline Eigen::Matrix2d slope_at(const BoardView& view, std::size_t corner) {
  return view.slopes.empty() ? Eigen::Matrix2d(Eigen::Matrix2d::Zero()) : view.slopes[corner];
}

/// Corners whose projector pixel is known.
inline int lit_corners(const BoardView& view) {
  int count = 0;
  for (const Eigen::Vector2d& pixel : view.projector) count += pixel.allFinite() ? 1 : 0;
  return count;
}

/// How many boards cover each of the cells into which a device's picture is divided, 100 of
/// them across. Only the hull of a board's corners counts.
Image<std::uint8_t> coverage_map(const BoardViews& views, Device device, Size size);

/// Share of the cells that some board covers.
double covered_share(const Image<std::uint8_t>& coverage);

}  // namespace slipstream
