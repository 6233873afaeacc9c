#include "paper/published_loops.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include "decode/equations.h"

namespace slipstream {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

template <class Number, std::size_t N>
double mean_of(const std::array<Number, N>& I) {
  return static_cast<double>(std::accumulate(I.begin(), I.end(), Number{})) / N;
}

/// (U, V) of the frames.
template <class Number, std::size_t N>
TableIndex<Number> index_of(const ClosedForm& form, const std::array<Number, N>& I) {
  return table_index<Number>(form, std::span<const Number>(I));
}

/// C_N and S_N without the factor 2 / N, Eqs. (1.5), (1.6).
template <std::size_t N>
struct Sums {
  std::array<double, N> cosines{}, sines{};

  Sums() {
    for (std::size_t n = 0; n < N; ++n) {
      cosines[n] = std::cos(two_pi * static_cast<double>(n) / N);
      sines[n] = std::sin(two_pi * static_cast<double>(n) / N);
    }
  }
  [[nodiscard]] double C(const std::array<double, N>& I) const {
    return std::inner_product(I.begin(), I.end(), cosines.begin(), 0.0);
  }
  [[nodiscard]] double S(const std::array<double, N>& I) const {
    return std::inner_product(I.begin(), I.end(), sines.begin(), 0.0);
  }
};

}  // namespace

PointForm2 point_form2(const PointCoefficients& coefficients, double x, double y) {
  const PointForm1 form = point_form1(coefficients, x, y);
  const double M_x = form.A_x / form.C, M_y = form.A_y / form.C, M_z = form.A_z / form.C;
  return {M_x, form.B_x - M_x, M_y, form.B_y - M_y, M_z, form.B_z - M_z, form.C};
}

Eigen::Vector3d PointForm2::operator()(double y_p) const {
  const double T_2 = 1 / (C * y_p + 1);                        // (2.25)
  return {M_x + N_x * T_2, M_y + N_y * T_2, M_z + N_z * T_2};  // (2.26)-(2.28)
}

PublishedLoops::PublishedLoops(const Scanner& scanner, Axis axis, Frames<std::uint8_t> frames)
    : modulation(scanner.camera.size),
      phase(scanner.camera.size),
      x(scanner.camera.size),
      y(scanner.camera.size),
      z(scanner.camera.size),
      texture(scanner.camera.size),
      steps_(static_cast<int>(frames.size())),
      frames_(std::move(frames)),
      matrices_(projection_matrices(scanner, axis)),
      equations_(steps_),
      tables_(steps_),
      tables_of_4_(4),
      pixels_(undistorted_pixels(scanner.camera)),
      forms1_(point_table(pixels_, matrices_, point_form1)),
      forms2_(point_table(pixels_, matrices_, point_form2)),
      forms3_(point_table(pixels_, matrices_, point_form3)) {}

template <class Number, int N, class Sample>
void PublishedLoops::each_of(const Sample& sample) {
  for (int row = 0; row < phase.height(); ++row) {
    std::array<const std::uint8_t*, N> rows;
    for (std::size_t n = 0; n < N; ++n) rows[n] = frames_[n].row(row);
    for (int column = 0; column < phase.width(); ++column) {
      std::array<Number, N> I;
      for (std::size_t n = 0; n < N; ++n) I[n] = rows[n][column];
      sample(I, column, row);
    }
  }
}

template <class Number, class Sample>
void PublishedLoops::each_pixel(const Sample& sample) {
  if (steps_ == 3) return each_of<Number, 3>(sample);
  if (steps_ == 4) return each_of<Number, 4>(sample);
  each_of<Number, 6>(sample);
}

void PublishedLoops::set_point(int column, int row, const Eigen::Vector3d& point) {
  x(column, row) = point.x();
  y(column, row) = point.y();
  z(column, row) = point.z();
}

void PublishedLoops::general() {
  each_pixel<double>([&](const auto& I, int column, int row) {
    const PhaseSample sample = equations_(I);
    modulation(column, row) = sample.modulation;
    phase(column, row) = sample.wrapped_phase;
  });
}

void PublishedLoops::general_modulation() {
  each_pixel<double>([&]<std::size_t N>(const std::array<double, N>& I, int column, int row) {
    static const Sums<N> sums;
    const double C = sums.C(I), S = sums.S(I);
    modulation(column, row) = 2.0 / N * std::sqrt(S * S + C * C);
  });
}

void PublishedLoops::general_phase() {
  each_pixel<double>([&]<std::size_t N>(const std::array<double, N>& I, int column, int row) {
    static const Sums<N> sums;
    phase(column, row) = wrapped_angle(sums.S(I), sums.C(I));
  });
}

void PublishedLoops::closed_form() {
  const ClosedForm& form = tables_.form();
  each_pixel<double>([&](const auto& I, int column, int row) {
    const auto [U, V] = index_of(form, I);
    modulation(column, row) = form.modulation(U, V);
    phase(column, row) = form.wrapped_phase(U, V);
  });
}

void PublishedLoops::closed_modulation() {
  const ClosedForm& form = tables_.form();
  each_pixel<double>([&](const auto& I, int column, int row) {
    const auto [U, V] = index_of(form, I);
    modulation(column, row) = form.modulation(U, V);
  });
}

void PublishedLoops::closed_phase() {
  const ClosedForm& form = tables_.form();
  each_pixel<double>([&](const auto& I, int column, int row) {
    const auto [U, V] = index_of(form, I);
    phase(column, row) = form.wrapped_phase(U, V);
  });
}

void PublishedLoops::mlut() {
  each_pixel<int>([&](const auto& I, int column, int row) {
    const auto [U, V] = index_of(tables_.form(), I);
    modulation(column, row) = tables_.mlut(U, V);
  });
}

void PublishedLoops::plut() {
  each_pixel<int>([&](const auto& I, int column, int row) {
    const auto [U, V] = index_of(tables_.form(), I);
    phase(column, row) = tables_.plut(U, V);
  });
}

void PublishedLoops::mlut_plut() {
  each_pixel<int>([&](const auto& I, int column, int row) {
    const auto [U, V] = index_of(tables_.form(), I);
    modulation(column, row) = tables_.mlut(U, V);
    phase(column, row) = tables_.plut(U, V);
  });
}

void PublishedLoops::two_plus_one() {
  each_pixel<int>([&](const auto& I, int column, int row) {
    const int U = I[1] - I[2], V = I[0] - I[2];
    modulation(column, row) = 2 * tables_of_4_.mlut(U, V);
    phase(column, row) = tables_of_4_.plut(U, V);
  });
}

void PublishedLoops::inverse() {
  for_each_pixel_in_order(phase.size(), [&](int column, int row) {
    const PixelPosition& pixel = pixels_(column, row);
    set_point(column, row, triangulate(matrices_, pixel.x, pixel.y, phase(column, row) / two_pi));
  });
}

template <class Table>
void PublishedLoops::points_by(const Image<Table>& table) {
  for_each_pixel_in_order(phase.size(), [&](int column, int row) {
    set_point(column, row, table(column, row)(phase(column, row) / two_pi));
  });
}

void PublishedLoops::form1() {
  points_by(forms1_);
}
void PublishedLoops::form2() {
  points_by(forms2_);
}
void PublishedLoops::form3() {
  points_by(forms3_);
}

template <std::size_t N>
void PublishedLoops::set_inverse(int column, int row, const std::array<double, N>& I, double B,
                                 double phi) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const PixelPosition& pixel = pixels_(column, row);
  texture(column, row) = mean_of(I);
  set_point(column, row,
            B < least_modulation ? Eigen::Vector3d::Constant(nan)
                                 : triangulate(matrices_, pixel.x, pixel.y, phi / two_pi));
}

void PublishedLoops::equations() {
  each_pixel<double>([&](const auto& I, int column, int row) {
    const PhaseSample sample = equations_(I);
    set_inverse(column, row, I, sample.modulation, sample.wrapped_phase);
  });
}

void PublishedLoops::traditional() {
  const ClosedForm& form = tables_.form();
  each_pixel<double>([&](const auto& I, int column, int row) {
    const auto [U, V] = index_of(form, I);
    set_inverse(column, row, I, form.modulation(U, V), form.wrapped_phase(U, V));
  });
}

void PublishedLoops::lut() {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  each_pixel<int>([&](const auto& I, int column, int row) {
    const auto [U, V] = index_of(tables_.form(), I);
    texture(column, row) = mean_of(I);
    set_point(column, row,
              tables_.mlut(U, V) < least_modulation
                  ? Eigen::Vector3d::Constant(nan)
                  : forms3_(column, row)(tables_.plut(U, V) / two_pi));
  });
}

}  // namespace slipstream
