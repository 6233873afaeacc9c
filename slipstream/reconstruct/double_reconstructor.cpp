#include "slipstream/reconstruct/double_reconstructor.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/geometry/stripe_geometry.h"
#include "slipstream/image/parallel_rows.h"
#include "slipstream/phase/modulation_mask.h"

namespace slipstream {
namespace {

PointMethod point_method(Backend backend) {
  switch (backend) {
    case Backend::equation:
      return PointMethod::inverse;
    case Backend::closed_form:
      return PointMethod::form1;
    case Backend::lut:
    case Backend::fused:
      return PointMethod::form3;
  }
  return PointMethod::inverse;
}

}  // namespace

DoubleReconstructor::DoubleReconstructor(const Scanner& scanner, const Strategy& strategy,
                                         Axis axis, const ReconstructSettings& settings)
    : settings_(settings),
      axis_(axis),
      strategy_(strategy),
      highest_frequency_(highest_frequency(strategy)),
      triangulate_(scanner, axis, point_method(settings.backend)),
      decode_(strategy, length_along(axis, scanner.projector.size), settings.backend,
              settings.phase_corrections, settings.cue) {}

Reconstruction DoubleReconstructor::operator()(const FrameSet& frames) const {
  const Size camera = triangulate_.scanner().camera.size;
  if (frames.size() != camera) {
    throw Error(fmt::format("frames are {}x{}, the scanner's camera has {}x{}; both must agree",
                            frames.size().width, frames.size().height, camera.width,
                            camera.height));
  }
  DecodedScan decoded = decode_(frames, least_neighbour_modulation(settings_, frames.full_scale()));
  Cloud cloud = triangulated(decoded, measured(decoded, frames));
  const double grey_level = frames.full_scale() / 255;
  std::transform(decoded.mean.begin(), decoded.mean.end(), cloud.intensity.begin(),
                 [&](double mean) { return static_cast<float>(mean / grey_level); });
  return {std::move(cloud), std::move(decoded)};
}

Image<Validity> DoubleReconstructor::measured(const DecodedScan& decoded,
                                              const FrameSet& frames) const {
  const double least = least_modulation(settings_, frames.full_scale());
  const Image<std::uint8_t> lit = modulation_mask(decoded.modulation, least);
  const Image<std::uint8_t> saturated = saturation_mask(frames);
  const bool one_frequency = decoded.fringe_order_doubt.empty();
  const bool multiplexed = std::holds_alternative<PhaseChannelMultiplexing>(strategy_);
  const Image<std::uint8_t> asked =
      multiplexed ? modulation_mask(decoded.modulation,
                                    least_neighbour_modulation(settings_, frames.full_scale()))
                  : lit;
  const Image<std::uint8_t> unconfirmed =
      one_frequency ? Image<std::uint8_t>(frames.size())
                    : unconfirmed_fringe_orders(decoded.coordinate, decoded.fringe_order_doubt,
                                                asked, highest_frequency_, settings_.fringe_order);
  Image<Validity> validity(frames.size());
  for_each_row(frames.size().height, [&](int row) {
    for (int column = 0; column < frames.size().width; ++column) {
      if (lit(column, row) == 0) {
        validity(column, row) = Validity::too_dark;
      } else if (settings_.drop_saturated && saturated(column, row) != 0) {
        validity(column, row) = Validity::saturated;
      } else if (unconfirmed(column, row) != 0) {
        validity(column, row) = Validity::doubtful_order;
      }
    }
  });
  return validity;
}

Cloud DoubleReconstructor::triangulated(const DecodedScan& decoded,
                                        Image<Validity> validity) const {
  Cloud cloud(validity.size());
  cloud.validity = std::move(validity);
  for_each_row(cloud.size().height, [&](int row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      Validity& pixel = cloud.validity(column, row);
      if (pixel != Validity::valid) continue;
      const double coordinate = decoded.coordinate(column, row);
      const Eigen::Vector3d point = triangulate_(column, row, coordinate);
      pixel = validity_of(coordinate, point);
      if (pixel != Validity::valid) continue;
      cloud.x(column, row) = point.x();
      cloud.y(column, row) = point.y();
      cloud.z(column, row) = point.z();
    }
  });
  return cloud;
}

Uncertainty DoubleReconstructor::uncertainty(const Reconstruction& scan,
                                             const FrameSet& frames) const {
  constexpr double step = 1e-6;  // of y: 1e-3 mm in depth, where the point is a straight line of it
  const double grey_level = frames.full_scale() / 255;
  Uncertainty sigma(scan.cloud.size());
  for_each_row(scan.cloud.size().height, [&](int row) {
    for (int column = 0; column < scan.cloud.size().width; ++column) {
      if (scan.cloud.validity(column, row) != Validity::valid) continue;
      const double modulation = scan.decoded.modulation(column, row) / grey_level;
      const double sigma_y =
          std::sqrt(coordinate_variance(strategy_, modulation, settings_.cue.noise_variance));
      const double y = scan.decoded.coordinate(column, row);
      const Eigen::Vector3d sigma_point =
          (triangulate_(column, row, y + step) - triangulate_(column, row, y - step)).cwiseAbs() *
          (sigma_y / (2 * step));
      sigma.coordinate(column, row) = static_cast<float>(sigma_y);
      sigma.x(column, row) = static_cast<float>(sigma_point.x());
      sigma.y(column, row) = static_cast<float>(sigma_point.y());
      sigma.z(column, row) = static_cast<float>(sigma_point.z());
    }
  });
  return sigma;
}

Validity DoubleReconstructor::validity_of(double coordinate, const Eigen::Vector3d& point) const {
  if (!point.allFinite() || point.z() <= 0) return Validity::no_point;
  const Scanner& scanner = triangulate_.scanner();
  const Eigen::Vector3d in_projector = in_projector_frame(scanner, point);
  if (in_projector.z() <= 0) return Validity::no_point;
  const double end = farthest_past_field(length_along(axis_, scanner.projector.size));
  if (!(coordinate >= -end && coordinate <= 1 + end)) return Validity::outside_field;

  const Axis across = axis_ == Axis::x ? Axis::y : Axis::x;
  const double place =
      coordinate_along(across, project(scanner.projector, in_projector), scanner.projector.size);
  if (!(place >= -settings_.field_margin && place <= 1 + settings_.field_margin)) {
    return Validity::outside_field;
  }
  const bool in_range = point.z() >= settings_.nearest && point.z() <= settings_.farthest;
  return in_range ? Validity::valid : Validity::out_of_range;
}

}  // namespace slipstream
