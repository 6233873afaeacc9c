#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "decode/phase_decoder.h"
#include "slipstream/board_capture.h"
#include "slipstream/calibration_board.h"
#include "slipstream/scan.h"

namespace slipstream {

/// `corners`: of the board, pixels. `corrections`: phase corrections by N. Measures only if enough
/// pixels are bright. The frames must match the layout.
FringeSigns fringe_signs(const Scan& scan, const PixelPlaces& corners, double minimum_modulation,
                         const PhaseCorrections& corrections);

/// Whether the ripple exceeds both its noise and a harmless amplitude.
bool has_ripple(const FringeSigns& signs);

/// Above both of these, edges are soft.
inline constexpr double soft_pixels = 1.5, soft_spacings = 0.125;

/// True above 1/8 of a spacing (less than half of a square is then flat, and neighbouring edges
/// shift corners) and above 1.5 pixels, the blur of the pixels themselves.
bool is_soft(const EdgeSoftness& edges);

/// `places`: board places of the `corners` in the picture. Zero unless two neighbours are visible.
EdgeSoftness edge_softness(const Image<float>& picture, const CalibrationBoard& board,
                           const std::vector<int>& places, const PixelPlaces& corners);

enum class Device { camera, projector };

/// The corners in the device's picture.
inline const PixelPlaces& corners_of(const BoardView& view, Device device) {
  return device == Device::camera ? view.camera : view.projector;
}

/// `slopes` of a corner; zero if empty.
inline Eigen::Matrix2d slope_at(const BoardView& view, std::size_t corner) {
  return view.slopes.empty() ? Eigen::Matrix2d(Eigen::Matrix2d::Zero()) : view.slopes[corner];
}

/// Whether both devices see the corner.
inline bool is_lit(const BoardView& view, std::size_t corner) {
  return view.camera[corner].allFinite() && view.projector[corner].allFinite();
}

/// Number of corners that both devices see.
inline int lit_corners(const BoardView& view) {
  int count = 0;
  for (std::size_t i = 0; i < view.projector.size(); ++i) count += is_lit(view, i) ? 1 : 0;
  return count;
}

/// Number of boards that cover each cell of a device's picture, divided into 100 columns of square
/// cells. A board covers the hull of its corners.
Image<std::uint8_t> coverage_map(const BoardViews& views, Device device, Size size);

/// Share of the cells that at least one board covers.
double covered_share(const Image<std::uint8_t>& coverage);

}  // namespace slipstream
