#include "slipstream/reconstruct/epipolar.h"

#include <Eigen/Geometry>

#include "slipstream/base/numbers.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/base/statistics.h"
#include "slipstream/base/throw_if-inl.h"
#include "slipstream/codes/predicted_variance.h"
#include "slipstream/decode/band_unwrapper.h"
#include "slipstream/decode/decoder.h"
#include "slipstream/geometry/stripe_geometry.h"

namespace slipstream {
namespace {

/// Cubic convolution weights (Keys) of the four pixels around a position, `t` past the second.
std::array<double, 4> cubic_weights(double t) {
  const double u = 1 - t;
  return {-0.5 * t * u * u, 1 + t * t * (1.5 * t - 2.5), 1 + u * u * (1.5 * u - 2.5),
          -0.5 * u * t * t};
}

/// Disagreement of the two cameras' phases over a window: 1 - cos of their difference.
struct Disagreement {
  float sum = 0;
  float seen = 0;  ///< pixels that the second camera sees
};

/// For every pixel and fringe order; the orders of a pixel are adjacent.
struct OrderVolume {
  OrderVolume(Size size, int count)
      : orders(count), values(Size{size.width * count, size.height}) {}

  [[nodiscard]] Disagreement* at(int column, int row) { return &values(column * orders, row); }
  [[nodiscard]] const Disagreement* at(int column, int row) const {
    return &values(column * orders, row);
  }

  int orders;
  Image<Disagreement> values;
};

/// Half width of a window, pixels.
constexpr int reach = 7;

/// Adds to a pixel the values of up to `reach` pixels on one side, along (dx, dy), order by order.
void add_side(const OrderVolume& from, const CameraPhases& phases, int dx, int dy, int column,
              int row, Disagreement* to) {
  const Image<double>& phi = phases.maps.wrapped_phase;
  int turns = 0;
  for (int i = 1; i <= reach; ++i) {
    const int x = column + i * dx, y = row + i * dy;
    if (x < 0 || y < 0 || x >= phi.width() || y >= phi.height()) return;
    if (phases.validity(x, y) != Validity::valid) return;
    const double before = phi(x - dx, y - dy), turn = std::round((before - phi(x, y)) / two_pi);
    const double step = phi(x, y) + two_pi * turn - before;
    if (!(std::abs(step) < std::numbers::pi / 2)) return;  // the phase is not continuous
    turns += static_cast<int>(turn);
    const Disagreement* other = from.at(x, y);
    const int first = std::max(0, -turns), last = std::min(from.orders, from.orders - turns);
    for (int k = first; k < last; ++k) {
      to[k].sum += other[k + turns].sum;
      to[k].seen += other[k + turns].seen;
    }
  }
}

/// Sums over windows: first along rows, then along columns.
OrderVolume window_sums(OrderVolume volume, const CameraPhases& phases) {
  const Size size = phases.validity.size();
  for (const bool along_row : {true, false}) {
    OrderVolume summed = volume;
    for_each_pixel(size, [&](int column, int row) {
      if (phases.validity(column, row) != Validity::valid) return;
      for (const int side : {-1, 1}) {
        add_side(volume, phases, along_row ? side : 0, along_row ? 0 : side, column, row,
                 summed.at(column, row));
      }
    });
    volume = std::move(summed);
  }
  return volume;
}

/// The only order that fits; -1 if there is none.
int best_order(const Disagreement* orders, int count) {
  constexpr float fits = 0.1F;      // mean for phases half a radian apart
  constexpr float clearly = 0.15F;  // margin to the second best
  constexpr float fewest = 40;      // regions of fewer pixels may match by chance
  const float most = std::max_element(orders, orders + count, [](const auto& a, const auto& b) {
                       return a.seen < b.seen;
                     })->seen;
  int best = -1;
  float least = 2, second = 2;
  for (int k = 0; k < count; ++k) {
    if (orders[k].seen < std::max(fewest, 0.5F * most)) continue;
    const float mean = orders[k].sum / orders[k].seen;
    if (mean < least) {
      second = least;
      least = mean;
      best = k;
    } else {
      second = std::min(second, mean);
    }
  }
  return least < fits && second > least + clearly ? best : -1;
}

constexpr double least_limit = 0.5;  // projector pixels: error of a calibration

/// Maps of the scan along the other axis.
BasicMaps<double> maps_across(EngineSetup setup, const Scan& other) {
  throw_if(!has_coordinate(setup.sequence.strategy),
           "comparing both axes requires a strategy that gives a coordinate along each axis alone");
  setup.sequence = other.sequence;
  const Decoder decode(setup.sequence.strategy.layout(), projector_length(setup),
                       setup.settings.phase_method, phase_corrections(setup), cue_settings(setup));
  return decode(other.frames,
                least_neighbour_modulation(setup.settings, other.frames.full_scale()));
}

/// Marks points off their epipolar lines as doubtful; returns how many.
std::size_t leave_out_doubtful(Cloud& cloud, const Image<float>& off, const Image<float>& sigma) {
  std::size_t points = 0, doubted = 0;
  // The distance is NaN where the lens model does not reach a wrong coordinate: too far, too.
  const auto too_far = [&](int column, int row) {
    const double limit = std::max(least_limit, 5.0 * sigma(column, row));
    return sigma(column, row) > 0 && !(std::abs(off(column, row)) <= limit);
  };
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    ++points;
    doubted += too_far(column, row) ? 1 : 0;
  });
  const bool all = 3 * doubted > points;
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) == Validity::valid && (all || too_far(column, row)))
      cloud.leave_out(column, row, Validity::doubtful_order);
  });
  return all ? points : doubted;
}

/// Medians over the points, before any is rejected.
EpipolarCheck summary_of(const Image<float>& distance, const Image<float>& sigma,
                         const Cloud& cloud) {
  std::vector<double> distances, lengths, sigmas;
  for (std::size_t i = 0; i < sigma.pixel_count(); ++i) {
    const float off = distance.begin()[i];
    if (cloud.validity.begin()[i] != Validity::valid || std::isnan(off)) continue;
    distances.push_back(off);
    lengths.push_back(std::abs(off));
    sigmas.push_back(sigma.begin()[i]);
  }
  if (distances.empty()) return {};
  return {.median = median(std::move(distances)),
          .median_length = median(std::move(lengths)),
          .median_sigma = median(std::move(sigmas))};
}

}  // namespace

EpipolarDistance epipolar_distance(const Scanner& scanner, const Eigen::Vector3d& ray, double x,
                                   double y) {
  const Lens& projector = scanner.projector;
  const Eigen::Vector3d q =
      ray_through(projector, {x * projector.size.width, y * projector.size.height});
  const Eigen::Vector3d plane = scanner.translation.cross(scanner.rotation * ray);
  const Eigen::Vector2d line =
      projector.intrinsic.inverse().transpose().topLeftCorner<2, 3>() * plane;
  const double length = line.norm();
  return {q.dot(plane) / length, line / length};
}

bool EpipolarCheck::contradicts() const {
  return median_length > least_limit && median_length > 3 * median_sigma;
}

EpipolarCheck check_epipolar(const EngineSetup& setup, const Scan& other, Maps& maps,
                             Cloud& cloud) {
  const BasicMaps<double> other_maps = maps_across(setup, other);
  const double grey_level = other.frames.full_scale() / 255;
  const double least = least_modulation(setup.settings, other.frames.full_scale());
  const Image<std::uint8_t> saturated = saturation_mask(other.frames);
  const Layout& layout = setup.sequence.strategy.layout();
  const double unit = std::sqrt(coordinate_variance(layout, 1, cue_settings(setup).noise_variance));
  const auto sigma_of = [&](double modulation) {
    return layout.unwrapping->whole_stripes ? unit : unit * grey_level / modulation;
  };
  const auto [width, height] = setup.scanner.projector.size;
  const Size size = cloud.size();
  Image<float> off(size, static_cast<float>(nan)), sigma(size);
  for_each_pixel(size, [&](int column, int row) {
    const double B = maps.modulation(column, row), other_B = other_maps.modulation(column, row);
    if (!(std::min(B, other_B) >= least) || saturated(column, row) != 0) return;
    const auto [distance, normal] =
        epipolar_distance(setup.scanner, ray_through(setup.scanner.camera, {column, row}),
                          maps.coordinate(column, row), other_maps.coordinate(column, row));
    off(column, row) = static_cast<float>(distance);
    sigma(column, row) = static_cast<float>(
        std::hypot(normal.x() * width * sigma_of(B), normal.y() * height * sigma_of(other_B)));
  });
  EpipolarCheck check = summary_of(off, sigma, cloud);
  check.doubted = leave_out_doubtful(cloud, off, sigma);
  maps.epipolar_distance = std::move(off);
  return check;
}

Stereo::Stereo(const Scanner& first, const Scanner& second)
    : rotation(second.rotation.transpose() * first.rotation),
      translation(second.rotation.transpose() * (first.translation - second.translation)) {}

Eigen::Vector2d EpipolarLine::pixel(double depth) const {
  const Eigen::Vector3d point = stereo.rotation * (depth * ray) + stereo.translation;
  if (!(point.z() > 0)) return {nan, nan};
  return project(camera, point);
}

double EpipolarLine::difference(const Image<Phasor>& phase, Phasor reference, double depth) const {
  const Eigen::Vector2d place = pixel(depth);
  if (!(place.x() >= 1 && place.y() >= 1 && place.x() < phase.width() - 2 &&
        place.y() < phase.height() - 2)) {
    return nan;
  }
  const int left = static_cast<int>(place.x()), top = static_cast<int>(place.y());
  for (const int row : {top, top + 1}) {
    for (const int column : {left, left + 1}) {
      if (seen.validity(column, row) != Validity::valid) return nan;
    }
  }
  const auto across = cubic_weights(place.x() - left), down = cubic_weights(place.y() - top);
  Phasor sum = 0;
  for (int j = 0; j < 4; ++j) {
    const Phasor* row = phase.row(top - 1 + j) + left - 1;
    sum += down[j] *
           (across[0] * row[0] + across[1] * row[1] + across[2] * row[2] + across[3] * row[3]);
  }
  return std::arg(sum * std::conj(reference));
}

double EpipolarLine::depth_of_a_pixel(double depth) const {
  const double step = 1e-3 * depth;
  return step / (pixel(depth + step) - pixel(depth)).norm();
}

Image<double> order_by_other_camera(const SeeingCamera& camera, const SeeingCamera& other,
                                    double periods,
                                    const std::function<bool(const Eigen::Vector3d&)>& possible) {
  const Image<Validity>& validity = camera.phases.validity;
  const Image<double>& phi = camera.phases.maps.wrapped_phase;
  const Scanner &scanner = camera.triangulate.scanner(), &others = other.triangulate.scanner();
  const Stereo stereo(scanner, others);
  const int length = length_along(camera.triangulate.axis(), scanner.projector.size);
  const double end = 1 + farthest_past_field(length);
  OrderVolume volume(validity.size(), static_cast<int>(std::ceil(periods)));
  const auto for_each_valid = [&](const auto& visit) {
    for_each_pixel(validity.size(), [&](int column, int row) {
      if (validity(column, row) == Validity::valid) visit(column, row);
    });
  };
  for_each_valid([&](int column, int row) {
    const Phasor phasor = camera.phases.bands[0](column, row);
    for (int k = 0; k < volume.orders; ++k) {
      const double y = unwrapped_coordinate(phi(column, row), k, periods);
      const Eigen::Vector3d point = camera.triangulate(column, row, y);
      if (y > end || !(point.z() > 0) || !possible(point)) continue;
      const EpipolarLine line{stereo, others.camera, point / point.z(), other.phases};
      const double apart = line.difference(other.phases.bands[0], phasor, point.z());
      if (std::isnan(apart)) continue;
      volume.at(column, row)[k] = {static_cast<float>(1 - std::cos(apart)), 1};
    }
  });
  const OrderVolume windows = window_sums(std::move(volume), camera.phases);
  Image<double> coordinate(validity.size(), nan);
  for_each_valid([&](int column, int row) {
    const int k = best_order(windows.at(column, row), windows.orders);
    if (k >= 0) coordinate(column, row) = unwrapped_coordinate(phi(column, row), k, periods);
  });
  return coordinate;
}

}  // namespace slipstream
