#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "check/frame_model.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Points of coordinates compared with a scanner.
struct GeometryEvidence {
  double without_point = 0;  ///< share whose ray does not meet its stripe in front of both devices
  double outside = 0;        ///< share of points outside the projector's field
  double median_depth = 0;   ///< mm
  double out_of_range = 0;   ///< share of points outside the calibrated depths, with a margin
  double beyond = 0;         ///< the same with a tenth of the range as margin
  /// Median over the pixels inside of surfaces of the coordinate's change to the next pixel,
  /// divided by the change on a surface that faces the camera: about 1 if all is right, negative if
  /// the stripes run the other way, near 0 if they run along the other axis. The mean for a code
  /// alone. 1 if there are few such pixels.
  double slope = 1;
  double slope_doubt = 0;  ///< three standard errors of `slope`, from the scatter of the pixels
  /// Share of all changes of a code's coordinate that run the other way; for a code alone.
  double falling = 0;
};

/// How pictures were flipped before they were saved.
struct PictureTurn {
  bool columns = false;  ///< the right side is on the left
  bool rows = false;     ///< the top is at the bottom
};

/// A pixel and its projector coordinate.
struct CoordinateSample {
  /// From the pixel to the next one to the right and below.
  struct Change {
    Eigen::Vector2d coordinate;
    /// The same by the phase, exact but modulo a period; equal to `coordinate` without a phase.
    Eigen::Vector2d phase;
  };

  Eigen::Vector2d pixel;  ///< column, row
  double coordinate = 0;
  std::optional<Change> change{};  ///< nullopt where blur may mix two surfaces
};

/// How coordinates were measured.
struct CoordinateSource {
  double periods = 0;  ///< of the phase across the field; 0 if there is none
  double stripes = 0;  ///< of a code alone, whose coordinates change by whole stripes; otherwise 0
};

/// Ignores the projector's lens distortion: it moves points by less than these limits.
GeometryEvidence geometry_evidence(std::span<const CoordinateSample> samples,
                                   const CoordinateSource& source, const Scanner& scanner,
                                   Axis axis, const PictureTurn& turn = {});

CoordinateSource source_of(const FrameModel& model);

}  // namespace slipstream
