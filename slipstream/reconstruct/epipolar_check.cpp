#include "slipstream/reconstruct/epipolar_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/base/statistics.h"
#include "slipstream/codes/predicted_variance.h"
#include "slipstream/codes/unwrapping.h"
#include "slipstream/decode/decoder.h"

namespace slipstream {
namespace {

constexpr float no_number = std::numeric_limits<float>::quiet_NaN();
constexpr double least_limit = 0.5;  // projector pixels: what calibration may be off

EngineSetup along_other_axis(EngineSetup setup, const Scan& other) {
  if (!has_coordinate(setup.sequence.strategy)) {
    throw Error("patterns along both axes are compared where each gives a coordinate alone");
  }
  setup.sequence = other.sequence;
  return setup;
}

BasicMaps<double> maps_of(const EngineSetup& setup, const FrameViews& frames) {
  const Decoder decode(setup.sequence.strategy.layout(), projector_length(setup),
                       setup.settings.phase_method, phase_corrections(setup), cue_settings(setup));
  return decode(frames, least_neighbour_modulation(setup.settings, frames.full_scale()));
}

/// Returns how many points it took.
std::size_t leave_out_doubtful(Cloud& cloud, const Image<float>& off, const Image<float>& sigma) {
  Image<std::uint8_t> doubtful(cloud.size());
  std::size_t points = 0, doubted = 0;
  for (std::size_t i = 0; i < doubtful.pixel_count(); ++i) {
    if (cloud.validity.begin()[i] != Validity::valid) continue;
    const double limit = std::max(least_limit, 5.0 * sigma.begin()[i]);
    // Where a wrong coordinate leads out of the lens's model there is no distance.
    const bool too_far = sigma.begin()[i] > 0 && !(std::abs(off.begin()[i]) <= limit);
    doubtful.begin()[i] = too_far ? 1 : 0;
    ++points;
    doubted += too_far ? 1 : 0;
  }
  const bool all = 3 * doubted > points;
  for (std::size_t i = 0; i < doubtful.pixel_count(); ++i) {
    Validity& pixel = cloud.validity.begin()[i];
    if (pixel != Validity::valid || (doubtful.begin()[i] == 0 && !all)) continue;
    pixel = Validity::doubtful_order;
    cloud.x.begin()[i] = cloud.y.begin()[i] = cloud.z.begin()[i] = no_number;
  }
  return all ? points : doubted;
}

/// The medians over the points, before any is left out.
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
  const EngineSetup across_setup = along_other_axis(setup, other);
  const BasicMaps<double> other_maps = maps_of(across_setup, other.frames);
  const double grey_level = other.frames.full_scale() / 255;
  const double least = least_modulation(setup.settings, other.frames.full_scale());
  const Image<std::uint8_t> saturated = saturation_mask(other.frames);
  const Layout& layout = setup.sequence.strategy.layout();
  const double unit = std::sqrt(coordinate_variance(layout, 1, cue_settings(setup).noise_variance));
  const auto sigma_of = [&](double modulation) {
    return way_of(layout.unwrapping).whole_stripes ? unit : unit * grey_level / modulation;
  };
  const auto [width, height] = setup.scanner.projector.size;
  const Size size = cloud.size();
  Image<float> off(size, no_number), sigma(size);
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) {
      const double B = maps.modulation(column, row), other_B = other_maps.modulation(column, row);
      if (!(std::min(B, other_B) >= least) || saturated(column, row) != 0) continue;
      const auto [distance, normal] =
          epipolar_distance(setup.scanner, ray_through(setup.scanner.camera, {column, row}),
                            maps.coordinate(column, row), other_maps.coordinate(column, row));
      off(column, row) = static_cast<float>(distance);
      sigma(column, row) = static_cast<float>(
          std::hypot(normal.x() * width * sigma_of(B), normal.y() * height * sigma_of(other_B)));
    }
  });
  EpipolarCheck check = summary_of(off, sigma, cloud);
  check.doubted = leave_out_doubtful(cloud, off, sigma);
  maps.epipolar_distance = std::move(off);
  return check;
}

}  // namespace slipstream
