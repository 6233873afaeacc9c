#include "base/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

namespace slipstream {

Eigen::VectorXd solve_symmetric(const MatrixView& A, const VectorView& b) {
  return A.ldlt().solve(b);
}

std::optional<Eigen::MatrixXd> inverse_of_symmetric(const MatrixView& A, double least_pivot) {
  const Eigen::LDLT<Eigen::MatrixXd> factors(A);
  if (!(factors.vectorD().minCoeff() > least_pivot)) return std::nullopt;
  return factors.solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
}

Eigen::MatrixXd inverse_of(const MatrixView& A) {
  return A.inverse();
}

LeastSquares least_squares(const MatrixView& A, const MatrixView& B) {
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors(A);
  return {factors.solve(B), factors.rank()};
}

PrincipalAxes principal_axes(const MatrixView& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace slipstream
