// Which pixels become points, where the points are, and their uncertainty.

#include "reconstruct/points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "codes/predicted_variance.h"
#include "geometry/stripe_geometry.h"
#include "reconstruct/edge_sigma.h"
#include "reconstruct/engine_setup.h"
#include "response/correction.h"
#include "slipstream/engine.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Whether the projector's lens really lights the point through that pixel. Beyond the angle at
/// which its polynomial turns back, a lens model maps points outside the field into it.
bool is_lit(const Lens& lens, const Eigen::Vector3d& point, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d direction = point / point.z();

  // Only a shift this large can turn back; the exact test is expensive.
  constexpr double least_turn = 0.1;  // of the field
  const Eigen::Vector2d moved = (lens.intrinsic * direction).head<2>() - pixel;
  if (!(moved.norm() > least_turn * lens.size.width)) return true;

  // The ray through the pixel, by the inverse of the lens: another direction means that the model
  // has turned back.
  constexpr double largest_error = 1e-2;
  return !((ray_through(lens, pixel) - direction).norm() > largest_error);
}

/// |dy / d ln z| of a point along its pixel's ray: change of the projector coordinate for a
/// relative change of z. Needs only the forward projection of the projector's lens.
double change_along_ray(const Eigen::Vector3d& point, const EngineSetup& setup) {
  constexpr double step = 1e-6;  // small enough that y is linear in the distance
  const auto y = [&](double distance) { return coordinate_of(distance * point, setup); };
  return std::abs(y(1 + step) - y(1 - step)) / (2 * step);
}

/// How many times the predicted noise neighbouring coordinates really differ by: from two by two
/// pixels, so that slopes cancel; 1 if fewer than 100 places have them.
double noise_excess(const Cloud& cloud, const Maps& maps, const Uncertainty& sigma) {
  std::vector<float> ratios;
  const Size size = cloud.size();
  if (std::min(size.width, size.height) < 2) return 1;

  // The ratios at 4096 places spread over the picture.
  for (int i = 0; i < 4096; ++i) {
    const auto [x, y] = spread_place(i);
    const int column = static_cast<int>(x * (size.width - 1));
    const int row = static_cast<int>(y * (size.height - 1));

    // With -1 the mixed difference of four pixels, with 1 their sum.
    const auto twist = [&](const Image<float>& map, float sign) {
      return (map(column, row) + sign * map(column + 1, row)) +
             sign * (map(column, row + 1) + sign * map(column + 1, row + 1));
    };

    // At equal sigma the twist deviates by 2 sigma, and the sum is 4 sigma: a ratio of 1.
    const float ratio = 2 * std::abs(twist(maps.coordinate, -1)) / twist(sigma.coordinate, 1);
    if (ratio >= 0) ratios.push_back(ratio);  // no point, NaN, compares false
  }

  return ratios.size() < 100 ? 1 : deviation_from_median(double{quantile(ratios, 0.5)});
}

/// Random error of coordinates: noise / B, amplified by the correction of the response; of a code,
/// the width of the stripes that are about as likely.
class RandomError {
 public:
  RandomError(const EngineSetup& setup, double full_scale)
      : layout_(setup.sequence.strategy.layout()),
        photometry_(setup.scanner.photometry),
        band_(measuring_band(layout_)),
        run_(bent_run(band_)),
        grey_level_(full_scale / 255),
        noise_at_half_(cue_settings(setup).noise_variance),
        unit_variance_(coordinate_variance(layout_, 1, 1)) {}

  /// Whether it comes from noise, else from the width of stripes.
  [[nodiscard]] bool is_of_noise() const { return !layout_.unwrapping->whole_stripes; }

  /// Standard deviation, fields.
  [[nodiscard]] double at(const Maps& maps, int column, int row) const {
    const double unit = std::sqrt(unit_variance_);
    if (!is_of_noise()) return unit * likely_stripes(maps, column, row);

    const double modulation = maps.modulation(column, row) / grey_level_;
    const double noise_variance = noise_variance_at(maps.mean(column, row) / grey_level_,
                                                    noise_at_half_, photometry_.noise_gain);
    const double gain = gain_at(maps.coordinate(column, row));
    return unit * (gain * std::sqrt(noise_variance) / modulation);
  }

 private:
  /// Number of equally likely stripes of a code: 1 + 8 doubt.
  [[nodiscard]] static double likely_stripes(const Maps& maps, int column, int row) {
    const Image<float>& doubt = maps.fringe_order_doubt;
    return doubt.empty() ? 1 : 1 + 8 * doubt(column, row);
  }

  /// How much the correction amplifies noise at the phase of this coordinate.
  [[nodiscard]] double gain_at(double y) const {
    const auto& corrected = photometry_.response;
    if (!run_ || !corrected || band_.carrier != 0) return 1;

    const double phi = 2 * std::numbers::pi * band_.periods * y;
    return noise_gain(corrected->response, run_->steps, shifted_phase(run_->shifts, phi));
  }

  const Layout& layout_;
  const PhotometricCalibration& photometry_;
  const Band& band_;
  std::optional<StepRun> run_;
  double grey_level_, noise_at_half_, unit_variance_;
};

}  // namespace

double coordinate_of(const Eigen::Vector3d& point, const EngineSetup& setup) {
  const Lens& projector = setup.scanner.projector;
  const Eigen::Vector3d there = in_projector_frame(setup.scanner, point);
  if (!(there.z() > 0)) return nan;
  return coordinate_along(setup.sequence.axis, project(projector, there), projector.size);
}

Validity validity_of(double coordinate, const Eigen::Vector3d& point, const EngineSetup& setup) {
  // 1. In front of both devices.
  if (!point.allFinite() || point.z() <= 0) return Validity::no_point;
  const auto& [scanner, sequence, settings] = setup;
  const Eigen::Vector3d in_projector = in_projector_frame(scanner, point);
  if (in_projector.z() <= 0) return Validity::no_point;

  // 2. In the field, along the axis of the patterns and across it.
  const double end = farthest_past_field(projector_length(setup));
  if (!(coordinate >= -end && coordinate <= 1 + end)) return Validity::outside_field;

  const Axis other = across(sequence.axis);
  const Eigen::Vector2d pixel = project(scanner.projector, in_projector);
  const double place = coordinate_along(other, pixel, scanner.projector.size);
  if (!(place >= -settings.field_margin && place <= 1 + settings.field_margin) ||
      !is_lit(scanner.projector, in_projector, pixel)) {
    return Validity::outside_field;
  }

  // 3. In the depth range.
  const auto [nearest, farthest] = depth_range(setup);
  const bool in_range = point.z() >= nearest && point.z() <= farthest;
  return in_range ? Validity::valid : Validity::out_of_range;
}

Image<Validity> judged(const BasicMaps<double>& maps, const Image<Validity>& order,
                       const FrameViews& frames, const EngineSetup& setup) {
  // 1. Pixels with enough modulation, and those saturated in a frame that measures.
  const ReconstructSettings& settings = setup.settings;
  const Layout& layout = setup.sequence.strategy.layout();
  const double full_scale = frames.full_scale();
  const Image<std::uint8_t> lit =
      modulation_mask(maps.modulation, least_modulation(settings, full_scale));

  const std::vector<int> measuring = measuring_frames(layout);
  Image<std::uint8_t> saturated(frames.size()), unconfirmed(frames.size());
  if (settings.drop_saturated && !measuring.empty()) {
    saturated = saturation_mask(frames.chosen(measuring));
  }

  // 2. Fringe orders without enough neighbours that agree. Where neighbours voted on the order,
  //    darker ones confirm it too.
  if (!maps.fringe_order_doubt.empty()) {
    const bool voted = order_source(layout) == OrderSource::neighbours;
    const Image<std::uint8_t> voters =
        voted ? modulation_mask(maps.modulation, least_neighbour_modulation(settings, full_scale))
              : lit;

    FringeOrderConsensus consensus = settings.fringe_order;
    // Only a code's pixels with doubtful bits need neighbours: these may be stripes apart.
    if (layout.unwrapping->whole_stripes) consensus.fewest_neighbours = 0;

    unconfirmed = unconfirmed_fringe_orders(maps.coordinate, maps.fringe_order_doubt, voters,
                                            highest_frequency(layout), consensus);
  }

  // 3. The first reason that applies.
  Image<Validity> validity = order.empty() ? Image<Validity>(frames.size()) : order;
  for (std::size_t i = 0; i < validity.pixel_count(); ++i) {
    Validity& pixel = validity.begin()[i];
    if (lit.begin()[i] == 0) {
      pixel = Validity::too_dark;
    } else if (saturated.begin()[i] != 0) {
      pixel = Validity::saturated;
    } else if (unconfirmed.begin()[i] != 0) {
      pixel = Validity::doubtful_order;
    }
  }

  return validity;
}

BasicCloud<double> triangulated(const Image<double>& coordinates, Image<Validity> validity,
                                const Triangulator& triangulate, const EngineSetup& setup) {
  BasicCloud<double> cloud(validity.size());
  cloud.validity = std::move(validity);

  for_each_pixel(cloud.size(), [&](int column, int row) {
    Validity& pixel = cloud.validity(column, row);
    if (pixel != Validity::valid) return;

    const double coordinate = coordinates(column, row);
    const Eigen::Vector3d point = triangulate(column, row, coordinate);
    pixel = validity_of(coordinate, point, setup);
    if (pixel != Validity::valid) return;

    cloud.x(column, row) = point.x();
    cloud.y(column, row) = point.y();
    cloud.z(column, row) = point.z();
  });

  return cloud;
}

Uncertainty uncertainty_of(const Cloud& cloud, const Maps& maps, const EngineSetup& setup,
                           double full_scale) {
  const RandomError random_error(setup, full_scale);
  Uncertainty sigma(cloud.size());
  for_each_pixel(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    const double random = random_error.at(maps, column, row);

    // The point moves along its ray by this much for a change of y. At an edge the pixel's centre
    // is uncertain as well.
    const Eigen::Vector3d point = position_at(cloud, column, row);
    const Eigen::Vector3d by_y = point.cwiseAbs() / change_along_ray(point, setup);
    const double at_edge = edge_sigma(cloud, maps, column, row, std::abs(by_y.z()), random);
    const double sigma_y = std::hypot(random, at_edge);

    const Eigen::Vector3d sigma_point = sigma_y * by_y;
    sigma.coordinate(column, row) = static_cast<float>(sigma_y);
    sigma.x(column, row) = static_cast<float>(sigma_point.x());
    sigma.y(column, row) = static_cast<float>(sigma_point.y());
    sigma.z(column, row) = static_cast<float>(sigma_point.z());
    sigma.z_of_noise(column, row) = static_cast<float>(random * by_y.z());
  });

  // Unexplained noise larger than the explained: one-bit patterns in focus, fine speckle.
  constexpr double most_excess = 1.5;
  const double excess = random_error.is_of_noise() ? noise_excess(cloud, maps, sigma) : 1;
  if (excess <= most_excess) return sigma;

  for (Image<float>* const part :
       {&sigma.coordinate, &sigma.x, &sigma.y, &sigma.z, &sigma.z_of_noise}) {
    for (float& value : *part) value *= static_cast<float>(excess);
  }

  return sigma;
}

PictureReport picture_report(const FrameViews& frames, const Maps& maps,
                             const ReconstructSettings& settings) {
  const auto least = static_cast<float>(least_modulation(settings, frames.full_scale()));
  const Image<std::uint8_t> saturated = saturation_mask(frames);
  PictureReport report{.validity = Image<Validity>(frames.size())};

  std::vector<float> modulations;
  for (std::size_t i = 0; i < saturated.pixel_count(); ++i) {
    const float modulation = maps.modulation.begin()[i];
    Validity& pixel = report.validity.begin()[i];

    // Tested first: a pixel that is saturated in all frames has no modulation either.
    if (saturated.begin()[i] != 0) {
      pixel = Validity::saturated;
    } else if (!(modulation >= least)) {
      pixel = Validity::too_dark;
    } else {
      modulations.push_back(modulation);
    }
  }

  if (!modulations.empty()) {
    report.modulation = 255 / frames.full_scale() * static_cast<double>(quantile(modulations, 0.5));
  }

  return report;
}

Image<double> measured_coordinates(Engine& engine, const FrameViews& frames) {
  Maps maps;
  engine.maps(frames, maps);
  return measured_coordinates(engine, frames, maps);
}

Image<double> measured_coordinates(Engine& engine, const FrameViews& captured, const Maps& narrow) {
  // As the engine itself sees them: merged frames, and the least modulation that a cue needs.
  EngineSetup setup = engine.setup();
  raise_least_modulation(setup);
  setup.sequence = merged_sequence(std::move(setup.sequence));
  const FrameViews& frames = engine.merged(captured);

  throw_if(narrow.coordinate.empty(),
           "{}: more than one period covers the field, so these frames alone give "
           "no coordinate, only a wrapped phase",
           setup.sequence.strategy.name());

  BasicMaps<double> maps;
  convert(narrow, maps);
  const Image<Validity> validity = judged(maps, {}, frames, setup);

  std::ranges::transform(
      validity, maps.coordinate, maps.coordinate.begin(),
      [](Validity pixel, double y) { return pixel == Validity::valid ? y : nan; });

  return std::move(maps.coordinate);
}

}  // namespace slipstream
