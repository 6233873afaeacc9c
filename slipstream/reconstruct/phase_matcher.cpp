#include "slipstream/reconstruct/phase_matcher.h"

#include <Eigen/Dense>

#include "slipstream/base/numbers.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/base/throw_if-inl.h"
#include "slipstream/codes/unwrapping.h"
#include "slipstream/reconstruct/epipolar.h"

namespace slipstream {
namespace {

CameraPhases phases_of(const FrameViews& frames, const Decoder& decode,
                       const ReconstructSettings& settings) {
  LayoutPhases decoded = decode.demodulate(frames);
  CameraPhases phases{{}, {}, Image<Validity>(frames.size())};
  // Each band by itself: gamma may put the coordinate in different fringes in the two cameras.
  for (const std::size_t i : coarse_to_fine(decode.layout())) {
    const PhaseMaps& band = decoded.bands[i];
    auto& phasors = phases.bands.emplace_back(band.wrapped_phase.size());
    std::ranges::transform(band.modulation, band.wrapped_phase, phasors.begin(),
                           [](double B, double phi) { return std::polar(B, phi); });
  }
  if (phases.bands.size() == 1) phases.bands.push_back(phases.bands.front());
  phases.maps = decode.unwrapped(std::move(decoded), frames.full_scale(), 0);
  const double least = least_modulation(settings, frames.full_scale());
  std::ranges::transform(modulation_mask(phases.maps.modulation, least), saturation_mask(frames),
                         phases.validity.begin(), [&](std::uint8_t lit, std::uint8_t saturated) {
                           if (lit == 0) return Validity::too_dark;
                           return settings.drop_saturated && saturated != 0 ? Validity::saturated
                                                                            : Validity::valid;
                         });
  return phases;
}

/// Where the phases agree.
struct Match {
  double depth = nan;  ///< mm
  double slope = 0;    ///< of the phase over depth, rad / mm
};

/// The agreement nearest to `start`, within `farthest` pixels of the second camera.
Match nearest_match(const EpipolarLine& line, const Image<Phasor>& phase, Phasor reference,
                    double start, int farthest) {
  const double step = line.depth_of_a_pixel(start);
  if (!(step > 0) || !std::isfinite(step)) return {};
  const auto difference = [&](double depth) { return line.difference(phase, reference, depth); };
  const auto match_between = [&](double near, double far, double d_near, double d_far) -> Match {
    // At a full turn the sign changes too, but with a jump.
    if (!(d_near * d_far <= 0) || std::abs(d_far - d_near) > std::numbers::pi / 2) return {};
    double depth = std::lerp(near, far, d_near / (d_near - d_far));
    const double d = difference(depth);
    if (std::isfinite(d)) {
      // The phase is not linear between two pixels: interpolate again where the sign changes.
      depth = d * d_near <= 0 ? std::lerp(near, depth, d_near == d ? 0 : d_near / (d_near - d))
                              : std::lerp(depth, far, d == d_far ? 0 : d / (d - d_far));
    }
    const double slope = (difference(depth + step) - difference(depth - step)) / (2 * step);
    return {depth, slope};
  };
  Match nearest;
  double d_nearer = difference(start), d_farther = d_nearer;
  for (int i = 1; i <= farthest && !std::isfinite(nearest.depth); ++i) {
    for (const int side : {-1, 1}) {
      double& d_before = side < 0 ? d_nearer : d_farther;
      const double next = start + side * i * step, d_next = difference(next);
      const Match match = match_between(start + side * (i - 1) * step, next, d_before, d_next);
      const bool farther = std::abs(match.depth - start) >= std::abs(nearest.depth - start);
      if (std::isfinite(match.depth) && !farther) nearest = match;
      d_before = d_next;
    }
  }
  return nearest;
}

/// Search range in the second camera on either side of the place given by the projector, as a share
/// of the width; with gamma 3, three steps are off by a tenth of the field.
constexpr double coarse_reach = 0.15;
/// Search range around the coarse match, which is good to a few pixels.
constexpr int fine_reach = 12;

/// Matches band by band, from few periods to many; `fringes`: a period of each, in rad of the last.
Match match_pixel(const EpipolarLine& line, const CameraPhases& first, const CameraPhases& second,
                  int column, int row, double guess, const std::vector<double>& fringes) {
  const int reach = static_cast<int>(coarse_reach * second.bands[0].width());
  Match match = nearest_match(line, second.bands[0], first.bands[0](column, row), guess, reach);
  for (std::size_t i = 1; i < first.bands.size() && std::isfinite(match.depth); ++i) {
    match =
        nearest_match(line, second.bands[i], first.bands[i](column, row), match.depth, fine_reach);
    // One fringe further the fine phase agrees again, but the coarse one does not.
    const double apart =
        line.difference(second.bands[i - 1], first.bands[i - 1](column, row), match.depth);
    if (!(std::abs(apart) < fringes[i] / 3)) return {};
  }
  return match;
}

/// Depth and weight of each pixel's match.
struct Matches {
  Image<double> depth;  ///< mm
  /// Inverse variance of the depth, up to a factor. Phase noise is proportional to 1 / B, and depth
  /// noise is the phase noise divided by the phase's slope.
  Image<double> weight;
  Image<double> pixel_step;  ///< mm per pixel of the second camera
};

/// Depth at the centre of a plane fitted to the window's matches: 1 / Z is linear in the image.
double plane_depth(const Matches& matches, int column, int row, int half_width) {
  const double centre = matches.depth(column, row);
  const double step = matches.pixel_step(column, row);
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  int count = 0;
  for (int dy = -half_width; dy <= half_width; ++dy) {
    for (int dx = -half_width; dx <= half_width; ++dx) {
      const int x = column + dx, y = row + dy;
      if (x < 0 || y < 0 || x >= matches.depth.width() || y >= matches.depth.height()) continue;
      const double depth = matches.depth(x, y);
      // On a surface seen by both cameras, depth changes by less than a pixel per pixel.
      const bool same_surface =
          std::abs(depth - centre) <= step * (1 + std::abs(dx) + std::abs(dy));
      if (!same_surface) continue;
      const double weight = matches.weight(x, y);
      const Eigen::Vector3d place(1, dx, dy);
      A += weight * place * place.transpose();
      b += weight / depth * place;
      ++count;
    }
  }
  if (count < 6) return centre;
  const Eigen::Vector3d plane = A.ldlt().solve(b);
  return plane.allFinite() && plane.x() > 0 ? 1 / plane.x() : centre;
}

void require_pair(const Scanner& first, const Scanner& second, const PhaseMatchSettings& match) {
  require_valid(first);
  require_valid(second);
  throw_if(first.projector.size != second.projector.size ||
               !first.projector.intrinsic.isApprox(second.projector.intrinsic),
           "the two cameras' scanners have different projectors; both must have the same");
  throw_if(Stereo(first, second).translation.norm() < 1e-9,
           "the two cameras are in the same place and measure no depth; check their translations");
  throw_if(match.window < 0 || match.window > 100,
           "match window {} is out of range; 0 to 100 pixels", match.window);
}

/// One period of each band, from few periods to many, in rad of the band before.
std::vector<double> fringes_of(const Layout& layout) {
  std::vector<double> fringes;
  double before = 0;
  for (const std::size_t i : coarse_to_fine(layout)) {
    const double periods = layout.bands[i].periods;
    fringes.push_back(fringes.empty() ? two_pi : two_pi * before / periods);
    before = periods;
  }
  if (fringes.size() == 1) fringes.push_back(two_pi);
  return fringes;
}

/// Coordinates of one band of many periods; each camera resolves the other's orders.
struct SearchedOrders {
  double period = 1;  ///< of the field
  Image<double> first, second;

  /// Whether the second camera finds the same point: where the right place is hidden from it, a
  /// wrong one may match by chance, but not both ways.
  [[nodiscard]] bool seen_from_second(const Eigen::Vector2d& place, double y) const {
    const double other =
        second(static_cast<int>(std::lround(place.x())), static_cast<int>(std::lround(place.y())));
    return std::abs(other - y) < period / 2;
  }
};

SearchedOrders search_orders(const CameraPhases& first, const CameraPhases& second,
                             const EngineSetup& setup, const Triangulator& of_first,
                             const Triangulator& of_second) {
  const SeeingCamera here{first, of_first}, there{second, of_second};
  const Stereo back(of_second.scanner(), setup.scanner);
  const DepthRange depths = depth_range(setup);
  const auto within = [&](double z) { return z > depths.nearest && z < depths.farthest; };
  const double periods = highest_frequency(setup.sequence.strategy);
  return {1 / periods,
          order_by_other_camera(here, there, periods,
                                [&](const Eigen::Vector3d& point) { return within(point.z()); }),
          order_by_other_camera(there, here, periods, [&](const Eigen::Vector3d& point) {
            return within((back.rotation * point + back.translation).z());
          })};
}

void require_size(const FrameViews& frames, const Scanner& scanner, std::string_view which) {
  throw_if(frames.size() != scanner.camera.size,
           "frames of the {} camera are {}, its scanner says {}; both must agree", which,
           text_of(frames.size()), text_of(scanner.camera.size));
}

}  // namespace

PhaseMatcher::PhaseMatcher(const Scanner& first, const Scanner& second, const Sequence& sequence,
                           const ReconstructSettings& settings, const PhaseMatchSettings& match)
    : first_{first, sequence, settings},
      second_(second),
      match_(match),
      triangulate_(first, sequence.axis, PointMethod::form3),
      decode_(sequence.strategy.layout(), projector_length(first_), settings.phase_method) {
  require_valid(first_);
  require_pair(first, second, match);
  throw_if(order_source(decode_.layout()) != OrderSource::bands,
           "{}: frames cannot be matched between cameras; use a strategy of sinusoids, one band "
           "or bands that unwrap each other, or --one-camera",
           sequence.strategy.name());
  if (!has_coordinate(sequence.strategy)) {
    second_triangulate_.emplace(second, sequence.axis, PointMethod::form3);
  }
}

PhaseMatcher::Result PhaseMatcher::operator()(const FrameViews& first_frames,
                                              const FrameViews& second_frames) const {
  const ReconstructSettings& settings = first_.settings;
  require_size(first_frames, first_.scanner, "first");
  require_size(second_frames, second_, "second");
  CameraPhases first = phases_of(first_frames, decode_, settings);
  const CameraPhases second = phases_of(second_frames, decode_, settings);
  const DepthRange depths = depth_range(first_);
  const Stereo stereo(first_.scanner, second_);
  const std::vector<double> fringes = fringes_of(decode_.layout());
  const Size size = first_frames.size();

  std::optional<SearchedOrders> searched;
  if (second_triangulate_) {
    searched = search_orders(first, second, first_, triangulate_, *second_triangulate_);
    first.maps.coordinate = searched->first;
  }

  Matches matches{Image<double>(size, nan), Image<double>(size), Image<double>(size)};
  Image<PixelPosition> directions(size);
  for_each_pixel(size, [&](int column, int row) {
    if (first.validity(column, row) != Validity::valid) return;
    const Eigen::Vector3d ray = ray_through(first_.scanner.camera, {column, row});
    directions(column, row) = {ray.x(), ray.y()};
    const double y = first.maps.coordinate(column, row);
    const double guess = triangulate_(column, row, y).z();
    if (!ray.allFinite() || !(guess > 0)) return;
    const EpipolarLine line{stereo, second_.camera, ray, second};
    const Match match = match_pixel(line, first, second, column, row, guess, fringes);
    if (!std::isfinite(match.depth) || !std::isfinite(match.slope) || match.slope == 0) return;
    if (searched) {
      const double quarter = searched->period / 4;
      const double beside = triangulate_(column, row, y + quarter).z();
      if (!(std::abs(match.depth - guess) < std::abs(beside - guess))) return;
      if (!searched->seen_from_second(line.pixel(match.depth), y)) return;
    }
    matches.depth(column, row) = match.depth;
    matches.weight(column, row) = std::norm(match.slope * first.bands.back()(column, row));
    matches.pixel_step(column, row) = line.depth_of_a_pixel(match.depth);
  });

  Cloud cloud(size);
  cloud.validity = std::move(first.validity);
  const double grey_level = first_frames.full_scale() / 255;
  for_each_pixel(size, [&](int column, int row) {
    cloud.intensity(column, row) = static_cast<float>(first.maps.mean(column, row) / grey_level);
    Validity& pixel = cloud.validity(column, row);
    if (pixel != Validity::valid) return;
    if (!std::isfinite(matches.depth(column, row))) {
      pixel = searched && std::isnan(searched->first(column, row)) ? Validity::doubtful_order
                                                                   : Validity::no_point;
      return;
    }
    const double Z = plane_depth(matches, column, row, match_.window);
    if (Z < depths.nearest || Z > depths.farthest) {
      pixel = Validity::out_of_range;
      return;
    }
    cloud.x(column, row) = static_cast<float>(Z * directions(column, row).x);
    cloud.y(column, row) = static_cast<float>(Z * directions(column, row).y);
    cloud.z(column, row) = static_cast<float>(Z);
  });
  Cleaner(settings.clean)(cloud);
  Result result{.cloud = std::move(cloud)};
  convert(first.maps, result.maps);
  return result;
}

}  // namespace slipstream
