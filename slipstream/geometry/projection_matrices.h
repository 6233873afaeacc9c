#pragma once

#include <Eigen/Core>

#include "slipstream/codes/axis.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// The rows of the perspective matrices that triangulation uses, Liu 2010, Eqs. (1.9), (1.10). The
/// projector's coordinate row is its second for patterns along y, as printed, and its first for
/// patterns along x, divided by the projector's length so that y^p is in [0, 1).
struct ProjectionMatrices {
  Eigen::Matrix<double, 3, 4> camera;                ///< M^c
  Eigen::Matrix<double, 1, 4> projector_coordinate;  ///< m_2^p (m_1^p for axis x) / length
  Eigen::Matrix<double, 1, 4> projector_depth;       ///< m_3^p
};

/// M^c = K^c [I 0], M^p = K^p [R T], lenses without distortion.
ProjectionMatrices projection_matrices(const Scanner& scanner, Axis axis);

/// The scanner of a camera and a projector given by their perspective matrices in one world frame,
/// mm, up to scale: lenses without distortion, perhaps with skew. Throws Error where a matrix is
/// not of a camera: its first three columns are singular.
Scanner scanner_of(const Eigen::Matrix<double, 3, 4>& camera, Size camera_size,
                   const Eigen::Matrix<double, 3, 4>& projector, Size projector_size);

/// Point at undistorted camera pixel (x, y) and undistorted projector coordinate y_p, by inverting
/// the matrix of Eq. (1.15); right-hand side as corrected in docs/errata.md. Not finite where the
/// ray lies in the plane of that coordinate.
Eigen::Vector3d triangulate(const ProjectionMatrices& matrices, double x, double y, double y_p);

}  // namespace slipstream
