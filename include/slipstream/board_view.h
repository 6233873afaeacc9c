#pragma once

#include <string>

#include "slipstream/calibration_board.h"
#include "slipstream/phase_decoder.h"
#include "slipstream/scan.h"

namespace slipstream {

/// Quality of one scan of a board, from a few thousand bright, unsaturated pixels.
struct FringeSigns {
  double saturated = 0;  ///< share of the board's pixels with a saturated frame
  int steps = 0;         ///< N of the measuring band; 0 if it is not a run of steps
  double period = 0;     ///< of the measuring band's fringe, projector pixels; 0 if not measured
  /// Amplitude and standard deviation, rad, of the phase error that repeats N times per fringe,
  /// relative to the smooth phase of a flat board.
  double ripple = 0;
  double ripple_deviation = 0;
  /// Ratio of the finest to the coarsest band's modulation, each divided by its share: 1 for sharp
  /// fringes, less if blurred.
  double contrast = 1;
};

/// `corners`: of the board, pixels. `corrections`: phase corrections by N. Measures only if enough
/// pixels are bright. The frames must match the layout.
FringeSigns fringe_signs(const Scan& scan, const PixelPlaces& corners, double minimum_modulation,
                         const PhaseCorrections& corrections);

/// Whether the ripple exceeds both its noise and a harmless amplitude.
bool has_ripple(const FringeSigns& signs);

/// Blur of the board's printed edges in a picture: standard deviation of the equivalent Gaussian,
/// median over all edges, in pixels and in spacings of the board.
struct EdgeSoftness {
  double pixels = 0;
  double spacings = 0;
};

/// True above 1/8 of a spacing (less than half of a square is then flat, and neighbouring edges
/// shift corners) and above 1.5 pixels, the blur of the pixels themselves.
bool is_soft(const EdgeSoftness& edges);

/// `places`: board places of the `corners` in the picture. Zero unless two neighbours are visible.
EdgeSoftness edge_softness(const Image<float>& picture, const CalibrationBoard& board,
                           const std::vector<int>& places, const PixelPlaces& corners);

/// Quality of one pose's frames.
struct CaptureSigns {
  FringeSigns x{};
  FringeSigns y{};
  EdgeSoftness edges{};
};

/// One pose of the board: its corners in the camera's and the projector's picture.
struct BoardView {
  std::string name;         ///< of the pose's folder
  std::vector<int> places;  ///< board place of each corner
  PixelPlaces camera;       ///< pixels
  PixelPlaces projector;    ///< pixels; NaN where unknown
  /// d projector / d camera: an error of a corner's camera pixel causes this error of its projector
  /// pixel. Empty or zero if the projector pixels are independent of the camera's.
  std::vector<Eigen::Matrix2d> slopes{};
  CaptureSigns signs{};  ///< quality of its frames; default if it has none
};

using BoardViews = std::vector<BoardView>;

enum class Device { camera, projector };

/// The corners in the device's picture.
inline const PixelPlaces& corners_of(const BoardView& view, Device device) {
  return device == Device::camera ? view.camera : view.projector;
}

/// `slopes` of a corner; zero if empty.
inline Eigen::Matrix2d slope_at(const BoardView& view, std::size_t corner) {
  return view.slopes.empty() ? Eigen::Matrix2d(Eigen::Matrix2d::Zero()) : view.slopes[corner];
}

/// Number of corners with a known projector pixel.
inline int lit_corners(const BoardView& view) {
  return static_cast<int>(std::ranges::count_if(view.projector, &Eigen::Vector2d::allFinite));
}

/// Number of boards that cover each cell of a device's picture, divided into 100 columns of square
/// cells. A board covers the hull of its corners.
Image<std::uint8_t> coverage_map(const BoardViews& views, Device device, Size size);

/// Share of the cells that at least one board covers.
double covered_share(const Image<std::uint8_t>& coverage);

}  // namespace slipstream
