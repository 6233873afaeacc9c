#include "slipstream/reconstruct/table_engine.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "slipstream/base/numbers.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/base/throw_if-inl.h"
#include "slipstream/reconstruct/pipeline.h"

namespace slipstream {
namespace {

constexpr int nodes = 8;

/// The undistorted projector coordinate minus y, where y is in the depth range of the pixel: a
/// polynomial c_0 + c_1 u + ... + c_7 u^7 of u = (y - middle) / half, in [-1, 1].
struct LensPolynomial {
  float middle = 0.5F, half = 0.5F;
  std::array<float, nodes> c{};

  [[nodiscard]] double operator()(double y) const {
    const double u = (y - middle) / half;
    double sum = c[nodes - 1];
    for (int k = nodes - 2; k >= 0; --k) sum = sum * u + c[k];
    return sum;
  }
};

/// Zeros of the Chebyshev polynomial of that degree, in [-1, 1].
std::array<double, nodes> node_places() {
  std::array<double, nodes> places;
  for (int j = 0; j < nodes; ++j) {
    places[j] = -std::cos((2 * j + 1) * std::numbers::pi / (2 * nodes));
  }
  return places;
}

/// Sets `middle` and `half` to the coordinates at the ends of the depth range, in the field.
void set_interval(LensPolynomial& polynomial, const Eigen::Vector3d& ray, DepthRange depths,
                  const Scanner& scanner, Axis axis) {
  constexpr double shortest = 10, longest = 1e5;  // mm, of a range without ends
  const auto coordinate_at = [&](double depth) {
    const Eigen::Vector3d point = in_projector_frame(scanner, depth * ray);
    const double y =
        coordinate_along(axis, project(scanner.projector, point), scanner.projector.size);
    return point.z() > 0 && std::isfinite(y) ? std::clamp(y, -0.02, 1.02) : 0.5;
  };
  const double first = coordinate_at(std::max(depths.nearest, shortest));
  const double last = coordinate_at(std::min(depths.farthest, longest));
  polynomial.middle = static_cast<float>((first + last) / 2);
  polynomial.half = static_cast<float>(std::max(std::abs(first - last) / 2, 1e-3));
}

/// Of each pixel, by the points that the reference finds at the nodes; NaN if it finds none.
Image<LensPolynomial> lens_table(const Triangulator& triangulate,
                                 const ProjectionMatrices& matrices, DepthRange depths) {
  const std::array<double, nodes> places = node_places();
  using Square = Eigen::Matrix<double, nodes, nodes>;
  Square powers;
  for (int j = 0; j < nodes; ++j) {
    for (int k = 0; k < nodes; ++k) powers(j, k) = std::pow(places[j], k);
  }
  const Square solve = powers.inverse();

  const Scanner& scanner = triangulate.scanner();
  Image<LensPolynomial> table(scanner.camera.size);
  for_each_pixel(table.size(), [&](int column, int row) {
    LensPolynomial& entry = table(column, row);
    const Eigen::Vector3d ray = ray_through(scanner.camera, {column, row});
    set_interval(entry, ray, depths, scanner, triangulate.axis());

    Eigen::Vector<double, nodes> shift;
    for (int j = 0; j < nodes; ++j) {
      const double y = entry.middle + entry.half * places[j];
      const Eigen::Vector4d point = triangulate(column, row, y).homogeneous();
      const double undistorted =
          matrices.projector_coordinate.dot(point) / matrices.projector_depth.dot(point);
      shift[j] = undistorted - y;
    }
    const Eigen::Vector<double, nodes> polynomial = solve * shift;
    for (int k = 0; k < nodes; ++k) entry.c[k] = static_cast<float>(polynomial[k]);
  });
  return table;
}

/// Largest shift by the projector's lens across the axis, shares of the field.
double largest_shift(const Lens& lens, Axis across_axis) {
  constexpr int steps = 32;
  double largest = 0;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      const Eigen::Vector2d pixel(1.0 * lens.size.width * i / steps,
                                  1.0 * lens.size.height * j / steps);
      const Eigen::Vector3d straight = lens.intrinsic * ray_through(lens, pixel);
      const Eigen::Vector2d shift = straight.head<2>() - pixel;
      const double share = coordinate_along(across_axis, shift, lens.size);
      largest = std::max(largest, std::isfinite(share) ? std::abs(share)
                                                       : std::numeric_limits<double>::infinity());
    }
  }
  return largest;
}

}  // namespace

struct TableEngine::Tables {
  Tables(const EngineSetup& of, const StepRun& run, const PhaseCorrection* correction)
      : setup(of),
        phases(run.steps, correction),
        triangulate(of.scanner, of.sequence.axis, PointMethod::form3),
        matrices(projection_matrices(of.scanner, of.sequence.axis)),
        forms(point_table(undistorted_pixels(of.scanner.camera), matrices, point_form3)),
        depths(depth_range(of)),
        least_coordinate(-0.5 / projector_length(of)) {
    const Lens& projector = of.scanner.projector;
    if (!projector.distortion.is_zero()) lens = lens_table(triangulate, matrices, depths);

    // Inside this margin of the field, a lens that shifts by less cannot put a point outside it.
    const Axis other = across(of.sequence.axis);
    const double length = length_along(other, projector.size);
    safe_margin = of.settings.field_margin - 2 * largest_shift(projector, other) - 1 / length;
    across_coordinate = projection_matrices(of.scanner, other).projector_coordinate;
  }

  [[nodiscard]] Eigen::Vector3d point(int column, int row, double y) const {
    return forms(column, row)(lens.empty() ? y : y + lens(column, row)(y));
  }

  /// Whether the lens table gives the reference's points, compared between the nodes over the
  /// picture: to a hundred-thousandth of their depth, wherever they are in the depth range.
  [[nodiscard]] bool is_exact() const {
    constexpr int pixels = 16, coordinates = 24;
    const Size size = forms.size();
    for (int i = 0; i < pixels * pixels * coordinates; ++i) {
      const int column = (i % pixels) * (size.width - 1) / (pixels - 1);
      const int row = (i / pixels % pixels) * (size.height - 1) / (pixels - 1);
      const double y = (i / (pixels * pixels) + 0.5) / coordinates;
      const Eigen::Vector3d exact = triangulate(column, row, y);
      if (!(exact.z() > depths.nearest && exact.z() < depths.farthest)) continue;
      if (!is_surely_valid(exact)) continue;
      if (!((point(column, row, y) - exact).norm() < 1e-5 * exact.z())) return false;
    }
    return true;
  }

  /// Whether the point is valid for certain; others are judged by `validity_of`. The place across
  /// the axis is a ratio, place / depth; multiplied out, it needs no division.
  [[nodiscard]] bool is_surely_valid(const Eigen::Vector3d& point) const {
    const auto along = [&](const Eigen::Matrix<double, 1, 4>& row) {
      return row[0] * point[0] + row[1] * point[1] + row[2] * point[2] + row[3];
    };
    const double depth = along(matrices.projector_depth), place = along(across_coordinate);
    return point.z() > 0 && depth > 0 && point.z() >= depths.nearest &&
           point.z() <= depths.farthest && place >= -safe_margin * depth &&
           place <= (1 + safe_margin) * depth;
  }

  EngineSetup setup;
  PhaseTables phases;
  Triangulator triangulate;
  ProjectionMatrices matrices;
  Image<PointForm3> forms;
  Image<LensPolynomial> lens;  ///< empty without distortion
  DepthRange depths;
  double least_coordinate;  ///< left edge of the field's first pixel
  double safe_margin = 0;
  Eigen::Matrix<double, 1, 4> across_coordinate;
};

std::optional<TableEngine> TableEngine::make(const EngineSetup& setup,
                                             const PhaseCorrections& corrections,
                                             std::string* why_not) {
  const auto refuse = [&](const char* why) {
    *why_not = why;
    return std::nullopt;
  };
  if (setup.settings.phase_method != PhaseMethod::tables) return refuse("phases by other methods");
  if (unwraps_by_picture(setup)) return refuse("fringe orders come from the whole picture");

  const Layout& layout = setup.sequence.strategy.layout();
  const std::optional<StepRun> run = step_run(layout.bands.front());
  const bool has_tables = run && (run->steps == 3 || run->steps == 4 || run->steps == 6);
  const bool is_plain = layout.bands.size() == 1 && !layout.cue && !layout.code &&
                        layout.single_frames.empty() && layout.unwrapping == Unwrapping::none &&
                        layout.bands.front().periods == 1 && layout.bands.front().carrier == 0;
  if (!has_tables || !is_plain || run->first != 0 || run->steps != layout.frames ||
      run->shifts != Shifts{}) {
    return refuse("patterns other than 3, 4 or 6 steps of one period");
  }

  const auto correction = corrections.find(run->steps);
  auto tables = std::make_shared<Tables>(
      setup, *run, correction == corrections.end() ? nullptr : &correction->second);
  if (!tables->is_exact()) return refuse("a projector lens that no short polynomial describes");
  return TableEngine(std::move(tables));
}

bool TableEngine::takes(const FrameViews& frames, const Outputs& outputs) {
  const bool has_bytes = frames.visit(
      []<class Pixel>(const Frames<Pixel>&) { return std::is_same_v<Pixel, std::uint8_t>; });
  return has_bytes && !frames.merged() && outputs.depth == nullptr && outputs.depth16 == nullptr &&
         outputs.points == nullptr;
}

void TableEngine::operator()(const FrameViews& frames, const Outputs& outputs) const {
  const Tables& tables = *tables_;
  require_size(frames, tables.setup.scanner.camera.size);
  throw_if(frames.count() != tables.setup.sequence.strategy.layout().frames,
           "{} frames given; expected {}", frames.count(),
           tables.setup.sequence.strategy.layout().frames);

  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_same_v<Pixel, std::uint8_t>) {
      if (views.size() == 3) return run<3>(views, outputs);
      if (views.size() == 4) return run<4>(views, outputs);
      return run<6>(views, outputs);
    }
  });
}

template <int N>
void TableEngine::run(const Frames<std::uint8_t>& frames, const Outputs& outputs) const {
  const Tables& tables = *tables_;
  const Size size = tables.forms.size();
  const ClosedForm& form = tables.phases.form();
  const double least = least_modulation(tables.setup.settings, 255);
  const int saturation = tables.setup.settings.drop_saturated ? 255 : 256;
  constexpr float invalid = std::numeric_limits<float>::quiet_NaN();

  const auto prepare = [&](auto& image) {
    if (image.size() != size) image = std::decay_t<decltype(image)>(size);
  };
  Cloud* const cloud = outputs.cloud;
  Maps* const maps = outputs.maps;
  if (cloud != nullptr) {
    prepare(cloud->x), prepare(cloud->y), prepare(cloud->z);
    prepare(cloud->intensity), prepare(cloud->validity);
  }
  if (maps != nullptr) {
    prepare(maps->mean), prepare(maps->modulation);
    prepare(maps->wrapped_phase), prepare(maps->coordinate);
    maps->fringe_order_doubt = {};
  }
  if (outputs.modulation != nullptr) prepare(*outputs.modulation);

  for_each_row(size.height, [&](int row) {
    std::array<const std::uint8_t*, N> rows;
    for (int n = 0; n < N; ++n) rows[n] = frames[n].row(row);
    const PointForm3* const forms = tables.forms.row(row);
    const LensPolynomial* const lens = tables.lens.empty() ? nullptr : tables.lens.row(row);

    for (int column = 0; column < size.width; ++column) {
      // 1. U and V, integers: (2.4)-(2.9), (2.16)-(2.18).
      std::array<int, N> I;
      for (int n = 0; n < N; ++n) I[n] = rows[n][column];
      const auto [U, V] = table_index<int>(form, std::span<const int>(I));
      const double mean = std::accumulate(I.begin(), I.end(), 0) / double{N};

      // 2. Modulation and phase, looked up; the coordinate of one period across the field.
      const double B = tables.phases.mlut(U, V);
      const double phi = tables.phases.plut(U, V);
      double y = phi / two_pi;
      if (y >= 1 + tables.least_coordinate) y -= 1;

      if (outputs.modulation != nullptr) {
        (*outputs.modulation)(column, row) = static_cast<float>(B);
      }
      if (maps != nullptr) {
        maps->mean(column, row) = static_cast<float>(mean);
        maps->modulation(column, row) = static_cast<float>(B);
        maps->wrapped_phase(column, row) = static_cast<float>(phi);
        maps->coordinate(column, row) = static_cast<float>(y);
      }
      if (cloud == nullptr) continue;

      // 3. The point by the third form, (2.29)-(2.31), after the projector's lens.
      Validity validity = B < least                                    ? Validity::too_dark
                          : *std::ranges::max_element(I) >= saturation ? Validity::saturated
                                                                       : Validity::valid;
      Eigen::Vector3d point = Eigen::Vector3d::Constant(invalid);
      if (validity == Validity::valid) {
        point = forms[column](lens == nullptr ? y : y + lens[column](y));
        if (!tables.is_surely_valid(point)) {
          point = tables.triangulate(column, row, y);
          validity = validity_of(y, point, tables.setup);
        }
      }
      const bool is_point = validity == Validity::valid;
      cloud->x(column, row) = is_point ? static_cast<float>(point.x()) : invalid;
      cloud->y(column, row) = is_point ? static_cast<float>(point.y()) : invalid;
      cloud->z(column, row) = is_point ? static_cast<float>(point.z()) : invalid;
      cloud->intensity(column, row) = static_cast<float>(mean);
      cloud->validity(column, row) = validity;
    }
  });
}

}  // namespace slipstream
