#pragma once

#include <optional>

#include <Eigen/Core>

// Decompositions of matrices of any size. Eigen's are templates of the size, and each one takes GCC
// seconds in each source; these are compiled once. Loops over pixels use Eigen's own, for the size
// that they know.

namespace slipstream {

using MatrixView = Eigen::Ref<const Eigen::MatrixXd>;
using VectorView = Eigen::Ref<const Eigen::VectorXd>;

/// x of A x = b for a symmetric, positive semidefinite A, such as the matrix of normal equations.
/// Reads only the lower triangle of A.
Eigen::VectorXd solve_symmetric(const MatrixView& A, const VectorView& b);

/// The inverse of a symmetric, positive definite matrix. nullopt if a pivot of its decomposition
/// A = L D L^T is not above `least_pivot`, or NaN.
std::optional<Eigen::MatrixXd> inverse_of_symmetric(const MatrixView& A, double least_pivot);

/// The inverse of a square matrix; not finite if it has none.
Eigen::MatrixXd inverse_of(const MatrixView& A);

struct LeastSquares {
  Eigen::MatrixXd X;
  Eigen::Index rank = 0;  ///< of A
};

/// The X that minimises |A X - B|, column by column; the shortest, if A leaves X free.
LeastSquares least_squares(const MatrixView& A, const MatrixView& B);

/// Eigenvalues of a symmetric matrix, ascending, and its eigenvectors of length 1: a column for
/// each.
struct PrincipalAxes {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
PrincipalAxes principal_axes(const MatrixView& A);

}  // namespace slipstream
