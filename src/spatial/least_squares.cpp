// Weighted least-squares fit of a surface's differences to the wrapped ones, by conjugate gradients
// preconditioned by a cosine transform: Ghiglia and Romero, Journal of the Optical Society of
// America A 11 (1994). Uses the orders nearest to the surface.

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <unsupported/Eigen/FFT>

#include "base/parallel_rows.h"
#include "spatial/methods.h"

namespace slipstream {
namespace {

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Cosine transform of each row, DCT-II, or its inverse, DCT-III, up to scale.
void transform_rows(Rows& rows, bool back) {
  const auto n = static_cast<int>(rows.cols());
  if (n == 1) return;

  // The phase factors that turn the FFT of reordered samples into a cosine transform.
  std::vector<std::complex<float>> turns(n);
  for (int k = 0; k < n; ++k) {
    turns[k] = std::polar(1.F, static_cast<float>(-std::numbers::pi * k / (2 * n)));
  }

  for_each_row(static_cast<int>(rows.rows()), [&](int row) {
    Eigen::FFT<float> fft;
    Eigen::VectorXcf in(n), out(n);
    // Even indices from the left, odd ones from the right.
    const auto place = [&](int i) { return i % 2 == 0 ? i / 2 : n - 1 - i / 2; };

    if (!back) {
      for (int i = 0; i < n; ++i) in[place(i)] = rows(row, i);
      fft.fwd(out, in);
      for (int k = 0; k < n; ++k) rows(row, k) = (out[k] * turns[k]).real();
    } else {
      for (int k = 0; k < n; ++k) {
        const std::complex<float> value(rows(row, k), k == 0 ? 0.F : -rows(row, n - k));
        in[k] = value * std::conj(turns[k]);
      }

      fft.inv(out, in);
      for (int i = 0; i < n; ++i) rows(row, i) = out[place(i)].real();
    }
  });
}

/// The next length that is a product of small primes, for which transforms are fast.
int next_fast(int length) {
  for (;; ++length) {
    int rest = length;
    for (const int factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return length;
  }
}

/// Solves the problem without weights and holes, with zero padding to the right and below.
class CosinePreconditioner {
 public:
  void set_size(Size size) { size_ = size; }

  template <class Matrix>
  CosinePreconditioner& compute(const Matrix&) {
    return *this;
  }
  [[nodiscard]] static Eigen::ComputationInfo info() { return Eigen::Success; }

  [[nodiscard]] Eigen::VectorXf solve(const Eigen::VectorXf& of) const {
    const int width = next_fast(size_.width), height = next_fast(size_.height);

    // 1. The transform of the padded picture, rows first.
    Rows rows = Rows::Zero(height, width);
    rows.topLeftCorner(size_.height, size_.width) =
        Eigen::Map<const Rows>(of.data(), size_.height, size_.width);
    transform_rows(rows, false);
    Rows columns = rows.transpose();
    transform_rows(columns, false);

    // 2. Divides by the eigenvalues of the discrete Laplacian; the constant term is free.
    const auto curvature = [](int place, int length) {
      return 2 - 2 * std::cos(std::numbers::pi * place / length);
    };
    for_each_pixel({height, width}, [&](int y, int x) {
      const double both = curvature(x, width) + curvature(y, height);
      columns(x, y) = x + y == 0 ? 0 : static_cast<float>(columns(x, y) / both);
    });

    // 3. Back, and without the padding.
    transform_rows(columns, true);
    rows = columns.transpose();
    transform_rows(rows, true);

    const Rows inside = rows.topLeftCorner(size_.height, size_.width);
    return Eigen::Map<const Eigen::VectorXf>(inside.data(), of.size());
  }

 private:
  Size size_;
};

}  // namespace

Orders orders_by_least_squares(const WrappedCycles& wrapped) {
  const EdgeSteps steps = edge_steps(wrapped.cycles);
  const float* const cycles = wrapped.cycles.begin();
  const auto pixels = static_cast<int>(wrapped.cycles.pixel_count());

  Orders orders = flood(wrapped, steps);
  if (pixels == 0) return orders;

  // 1. Normal equations: a weighted Laplacian, at most four neighbours to a pixel.
  const Image<float> weights = smoothness(wrapped);
  Eigen::SparseMatrix<float, Eigen::RowMajor> matrix(pixels, pixels);
  matrix.reserve(Eigen::VectorXi::Constant(pixels, 5));
  Eigen::VectorXf right = Eigen::VectorXf::Zero(pixels);

  for (int at = 0; at < pixels; ++at) {
    float sum = 0;

    steps.for_each_neighbour(at, [&](int to, int step) {
      const float weight = std::min(weights.begin()[at], weights.begin()[to]);
      sum += weight;
      right[at] -= weight * (cycles[to] - cycles[at] + static_cast<float>(step));
      matrix.insert(at, to) = -weight;
    });

    matrix.insert(at, at) = sum;
  }

  // 2. The surface; its errors need only be small compared to a period.
  Eigen::ConjugateGradient<Eigen::SparseMatrix<float, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper,
                           CosinePreconditioner>
      solver;
  solver.preconditioner().set_size(wrapped.cycles.size());
  solver.setMaxIterations(50);
  solver.setTolerance(1e-4F);
  solver.compute(matrix);
  const Eigen::VectorXf surface = solver.solve(right);

  // 3. Each region's surface is known up to a constant: choose the one at which most phases agree.
  constexpr float turn = 2 * std::numbers::pi_v<float>;
  std::vector<std::complex<float>> phases(pixels);
  for (int at = 0; at < pixels; ++at) {
    const int region = orders.region.begin()[at];
    if (region < 0) continue;
    phases[region] += std::polar(1.F, turn * (surface[at] - cycles[at]));
  }

  // 4. The whole periods between each phase and the surface.
  for (int at = 0; at < pixels; ++at) {
    const int region = orders.region.begin()[at];
    if (region < 0) continue;

    const float constant = std::arg(phases[region]) / turn;
    orders.order.begin()[at] = static_cast<int>(std::lrint(surface[at] - cycles[at] - constant));
  }

  return orders;
}

}  // namespace slipstream
