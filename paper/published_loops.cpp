#include "paper/published_loops.h"

#include <array>
#include <limits>
#include <numbers>
#include <span>

namespace slipstream {
namespace {

constexpr int most_steps_published = 6;
constexpr double two_pi = 2 * std::numbers::pi;

/// The N intensities of one pixel.
template <class Number>
class Intensities {
 public:
  Intensities(const Frames<std::uint8_t>& frames, int column, int row) : count_(frames.size()) {
    for (std::size_t n = 0; n < count_; ++n) values_[n] = frames[n](column, row);
  }
  operator std::span<const Number>() const { return {values_.data(), count_}; }
  [[nodiscard]] double mean() const {
    Number sum = 0;
    for (std::size_t n = 0; n < count_; ++n) sum += values_[n];
    return static_cast<double>(sum) / static_cast<double>(count_);
  }

 private:
  std::array<Number, most_steps_published> values_;
  std::size_t count_;
};

}  // namespace

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
      pixels_(undistorted_pixels(scanner.camera)),
      forms1_(point_table(pixels_, matrices_, point_form1)),
      forms2_(point_table(pixels_, matrices_, point_form2)),
      forms3_(point_table(pixels_, matrices_, point_form3)) {}

template <class Sample>
void PublishedLoops::each_pixel(const Sample& sample) {
  for (int row = 0; row < phase.height(); ++row) {
    for (int column = 0; column < phase.width(); ++column) sample(column, row);
  }
}

void PublishedLoops::set_point(int column, int row, const Eigen::Vector3d& point) {
  x(column, row) = point.x();
  y(column, row) = point.y();
  z(column, row) = point.z();
}

void PublishedLoops::general() {
  each_pixel([&](int column, int row) {
    const PhaseSample sample = equations_(Intensities<double>(frames_, column, row));
    modulation(column, row) = sample.modulation;
    phase(column, row) = sample.wrapped_phase;
  });
}

void PublishedLoops::closed_form() {
  const ClosedForm& form = tables_.form();
  each_pixel([&](int column, int row) {
    const Intensities<double> intensities(frames_, column, row);
    const auto [U, V] = table_index<double>(form, std::span<const double>(intensities));
    modulation(column, row) = form.modulation(U, V);
    phase(column, row) = form.wrapped_phase(U, V);
  });
}

void PublishedLoops::mlut() {
  each_pixel([&](int column, int row) {
    const Intensities<int> intensities(frames_, column, row);
    const auto [U, V] = table_index<int>(tables_.form(), std::span<const int>(intensities));
    modulation(column, row) = tables_.mlut(U, V);
  });
}

void PublishedLoops::plut() {
  each_pixel([&](int column, int row) {
    const Intensities<int> intensities(frames_, column, row);
    const auto [U, V] = table_index<int>(tables_.form(), std::span<const int>(intensities));
    phase(column, row) = tables_.plut(U, V);
  });
}

void PublishedLoops::mlut_plut() {
  each_pixel([&](int column, int row) {
    const Intensities<int> intensities(frames_, column, row);
    const auto [U, V] = table_index<int>(tables_.form(), std::span<const int>(intensities));
    modulation(column, row) = tables_.mlut(U, V);
    phase(column, row) = tables_.plut(U, V);
  });
}

void PublishedLoops::inverse() {
  each_pixel([&](int column, int row) {
    const PixelPosition& pixel = pixels_(column, row);
    set_point(column, row, triangulate(matrices_, pixel.x, pixel.y, phase(column, row) / two_pi));
  });
}

template <class Table>
void PublishedLoops::points_by(const Image<Table>& table) {
  each_pixel([&](int column, int row) {
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

void PublishedLoops::traditional() {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  each_pixel([&](int column, int row) {
    const PhaseSample sample = equations_(Intensities<double>(frames_, column, row));
    texture(column, row) = sample.mean;
    const PixelPosition& pixel = pixels_(column, row);
    set_point(column, row,
              sample.modulation < least_modulation
                  ? Eigen::Vector3d::Constant(nan)
                  : triangulate(matrices_, pixel.x, pixel.y, sample.wrapped_phase / two_pi));
  });
}

void PublishedLoops::lut() {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  each_pixel([&](int column, int row) {
    const Intensities<int> intensities(frames_, column, row);
    const auto [U, V] = table_index<int>(tables_.form(), std::span<const int>(intensities));
    texture(column, row) = intensities.mean();
    set_point(column, row,
              tables_.mlut(U, V) < least_modulation
                  ? Eigen::Vector3d::Constant(nan)
                  : forms3_(column, row)(tables_.plut(U, V) / two_pi));
  });
}

}  // namespace slipstream
