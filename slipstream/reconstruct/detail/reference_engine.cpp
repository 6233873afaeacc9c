#include "slipstream/reconstruct/detail/reference_engine.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/codes/predicted_variance.h"
#include "slipstream/decode/modulation_mask.h"
#include "slipstream/decode/temporal_unwrapping.h"
#include "slipstream/geometry/stripe_geometry.h"
#include "slipstream/response/correction.h"

namespace slipstream {
namespace {

PointMethod point_method(PhaseMethod method) {
  switch (method) {
    case PhaseMethod::equation:
    case PhaseMethod::intensity_ratio:
      return PointMethod::inverse;
    case PhaseMethod::closed_form:
      return PointMethod::form1;
    case PhaseMethod::tables:
      return PointMethod::form3;
  }
  return PointMethod::inverse;
}

/// Whether the point is seen by the projector's lens at that pixel. Past the angle at which its
/// polynomial turns back, a lens seems to light from within its field what it does not.
bool is_lit(const Lens& lens, const Eigen::Vector3d& point, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d direction = point / point.z();
  // Only a lens that moves the point this far turns back; to ask it is dear.
  constexpr double least_turn = 0.1;  // of the field
  const Eigen::Vector2d moved = (lens.intrinsic * direction).head<2>() - pixel;
  if (!(moved.norm() > least_turn * lens.size.width)) return true;
  constexpr double largest_error = 1e-2;
  return !((ray_through(lens, pixel) - direction).norm() > largest_error);
}

}  // namespace

ReferenceEngine::ReferenceEngine(const EngineSetup& setup, const PhaseCorrections& corrections)
    : setup_(setup),
      triangulate_(setup.scanner, setup.sequence.axis, point_method(setup.settings.phase_method)),
      decode_(setup.sequence.strategy.layout(), projector_length(setup),
              setup.settings.phase_method, corrections, cue_settings(setup)) {
  if (unwraps_by_depth(setup)) unwrap_by_depth_.emplace(setup);
}

BasicMaps<double> ReferenceEngine::maps(const FrameViews& frames) const {
  Image<Validity> order;
  return maps(frames, order);
}

BasicMaps<double> ReferenceEngine::maps(const FrameViews& frames, Image<Validity>& order) const {
  const Size camera = setup_.scanner.camera.size;
  if (frames.size() != camera) {
    throw Error(fmt::format("frames are {}x{}, the scanner's camera has {}x{}; both must agree",
                            frames.size().width, frames.size().height, camera.width,
                            camera.height));
  }
  BasicMaps<double> decoded =
      decode_(frames, least_neighbour_modulation(setup_.settings, frames.full_scale()));
  if (unwrap_by_depth_) {
    DepthOrders orders;
    Image<float> phase, modulation;
    convert(decoded.wrapped_phase, phase);
    convert(decoded.modulation, modulation);
    (*unwrap_by_depth_)(phase, modulation, frames.full_scale(), orders);
    decoded.coordinate = Image<double>(camera, std::numeric_limits<double>::quiet_NaN());
    for_each_row(camera.height, [&](int row) {
      for (int column = 0; column < camera.width; ++column) {
        const int k = orders.order(column, row);
        if (k == SurfaceOrders::none) continue;
        decoded.coordinate(column, row) = unwrapped_coordinate(decoded.wrapped_phase(column, row),
                                                               k, unwrap_by_depth_->periods());
      }
    });
    order = std::move(orders.validity);
  }
  return decoded;
}

ReferenceResult ReferenceEngine::operator()(const FrameViews& frames) const {
  Image<Validity> order;
  BasicMaps<double> decoded = maps(frames, order);
  BasicCloud<double> cloud = triangulated(decoded.coordinate, measured(decoded, frames, order));
  const double grey_level = frames.full_scale() / 255;
  std::transform(decoded.mean.begin(), decoded.mean.end(), cloud.intensity.begin(),
                 [&](double mean) { return static_cast<float>(mean / grey_level); });
  return {std::move(cloud), std::move(decoded)};
}

Image<Validity> ReferenceEngine::measured(const BasicMaps<double>& decoded,
                                          const FrameViews& frames,
                                          const Image<Validity>& order) const {
  const ReconstructSettings& settings = setup_.settings;
  const double least = least_modulation(settings, frames.full_scale());
  const Image<std::uint8_t> lit = modulation_mask(decoded.modulation, least);
  const std::vector<int> measuring = measuring_frames(decode_.layout());
  const Image<std::uint8_t> saturated = measuring.empty()
                                            ? Image<std::uint8_t>(frames.size())
                                            : saturation_mask(frames.chosen(measuring));
  const bool nothing_to_confirm = decoded.fringe_order_doubt.empty();
  const bool voted = decode_.layout().unwrapping == Unwrapping::vote;
  const Image<std::uint8_t> asked =
      voted ? modulation_mask(decoded.modulation,
                              least_neighbour_modulation(settings, frames.full_scale()))
            : lit;
  const Image<std::uint8_t> unconfirmed =
      nothing_to_confirm
          ? Image<std::uint8_t>(frames.size())
          : unconfirmed_fringe_orders(decoded.coordinate, decoded.fringe_order_doubt, asked,
                                      highest_frequency(decode_.layout()), settings.fringe_order);
  Image<Validity> validity(frames.size());
  for_each_row(frames.size().height, [&](int row) {
    for (int column = 0; column < frames.size().width; ++column) {
      if (lit(column, row) == 0) {
        validity(column, row) = Validity::too_dark;
      } else if (settings.drop_saturated && saturated(column, row) != 0) {
        validity(column, row) = Validity::saturated;
      } else if (unconfirmed(column, row) != 0) {
        validity(column, row) = Validity::doubtful_order;
      } else if (!order.empty()) {
        validity(column, row) = order(column, row);
      }
    }
  });
  return validity;
}

BasicCloud<double> ReferenceEngine::triangulated(const Image<double>& coordinates,
                                                 Image<Validity> validity) const {
  BasicCloud<double> cloud(validity.size());
  cloud.validity = std::move(validity);
  for_each_row(cloud.size().height, [&](int row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      Validity& pixel = cloud.validity(column, row);
      if (pixel != Validity::valid) continue;
      const double coordinate = coordinates(column, row);
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

double ReferenceEngine::change_along_ray(const Eigen::Vector3d& point) const {
  constexpr double step = 1e-6;  // where y is a straight line of the distance
  const auto& [scanner, sequence, settings] = setup_;
  const auto y = [&](double distance) {
    const Eigen::Vector2d pixel =
        project(scanner.projector, in_projector_frame(scanner, distance * point));
    return coordinate_along(sequence.axis, pixel, scanner.projector.size);
  };
  return std::abs(y(1 + step) - y(1 - step)) / (2 * step);
}

Uncertainty ReferenceEngine::uncertainty(const Cloud& cloud, const Maps& maps,
                                         double full_scale) const {
  const double grey_level = full_scale / 255;
  const double at_half = cue_settings(setup_).noise_variance;
  const double by_light = setup_.scanner.photometry.noise_gain;
  const Band& band = measuring_band(decode_.layout());
  const std::optional<StepRun> run = bent_run(band);
  const auto& corrected = setup_.scanner.photometry.response;
  const bool by_noise = decode_.layout().unwrapping != Unwrapping::code_alone;
  const double unit_variance = coordinate_variance(decode_.layout(), 1, 1);
  Uncertainty sigma(cloud.size());
  for_each_row(cloud.size().height, [&](int row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      if (cloud.validity(column, row) != Validity::valid) continue;
      const double modulation = maps.modulation(column, row) / grey_level;
      const double noise_variance =
          noise_variance_at(maps.mean(column, row) / grey_level, at_half, by_light);
      const double y = maps.coordinate(column, row);
      const double phi = 2 * std::numbers::pi * band.periods * y;
      const double gain =
          run && corrected && band.carrier == 0
              ? noise_gain(corrected->response, run->steps, shifted_phase(run->shifts, phi))
              : 1;
      const double sigma_y = by_noise
                                 ? gain * std::sqrt(unit_variance * noise_variance) / modulation
                                 : std::sqrt(unit_variance);
      const Eigen::Vector3d point(cloud.x(column, row), cloud.y(column, row), cloud.z(column, row));
      const Eigen::Vector3d sigma_point = point.cwiseAbs() * (sigma_y / change_along_ray(point));
      sigma.coordinate(column, row) = static_cast<float>(sigma_y);
      sigma.x(column, row) = static_cast<float>(sigma_point.x());
      sigma.y(column, row) = static_cast<float>(sigma_point.y());
      sigma.z(column, row) = static_cast<float>(sigma_point.z());
    }
  });
  return sigma;
}

Validity ReferenceEngine::validity_of(double coordinate, const Eigen::Vector3d& point) const {
  if (!point.allFinite() || point.z() <= 0) return Validity::no_point;
  const auto& [scanner, sequence, settings] = setup_;
  const Eigen::Vector3d in_projector = in_projector_frame(scanner, point);
  if (in_projector.z() <= 0) return Validity::no_point;
  const double end = farthest_past_field(projector_length(setup_));
  if (!(coordinate >= -end && coordinate <= 1 + end)) return Validity::outside_field;

  const Axis other = across(sequence.axis);
  const Eigen::Vector2d pixel = project(scanner.projector, in_projector);
  const double place = coordinate_along(other, pixel, scanner.projector.size);
  if (!(place >= -settings.field_margin && place <= 1 + settings.field_margin) ||
      !is_lit(scanner.projector, in_projector, pixel)) {
    return Validity::outside_field;
  }
  const auto [nearest, farthest] = depth_range(setup_);
  const bool in_range = point.z() >= nearest && point.z() <= farthest;
  return in_range ? Validity::valid : Validity::out_of_range;
}

}  // namespace slipstream
