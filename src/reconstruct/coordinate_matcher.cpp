#include "reconstruct/coordinate_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/ranges.h>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "codes/predicted_variance.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/points.h"
#include "slipstream/strategy.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Larger changes of a coordinate between neighbouring pixels are edges of surfaces.
constexpr double steepest = 4;  // median changes

Image<EpipolarRay> epipolar_rays(const Lens& lens, const Eigen::Matrix3d& to_epipolar) {
  Image<EpipolarRay> rays(lens.size);
  for_each_pixel(lens.size, [&](int column, int row) {
    const Eigen::Vector3d d = to_epipolar * ray_through(lens, {column, row});
    rays(column, row) = {std::atan2(d.z(), d.y()), d.x() / std::hypot(d.y(), d.z())};
  });
  return rays;
}

/// Median change per pixel along rows or columns, between pixels `apart`; 0 without any.
double median_step(const Image<double>& y, bool along_rows, int apart = 1) {
  std::vector<double> steps;

  // Every second row and third column: a sample is enough for a median.
  for (int row = apart; row < y.height(); row += 2) {
    for (int column = apart; column < y.width(); column += 3) {
      const double before = along_rows ? y(column - apart, row) : y(column, row - apart);
      const double step = std::abs(y(column, row) - before) / apart;
      if (step >= 0) steps.push_back(step);  // NaN compares false
    }
  }

  return steps.empty() ? 0 : median(std::move(steps));
}

/// Turns a code's stripe centres into coordinates that change linearly between the edges of each
/// stripe. At the edge of a surface, the stripe's other edge gives its width.
void interpolate_stripes(Image<double>& y, double stripe) {
  constexpr int apart = 8;  // pixels: in wide stripes, most changes from pixel to pixel are 0

  // 1. Lines run across the stripes. A larger jump than `largest` between stripes is an edge of a
  //    surface.
  const double in_row = median_step(y, true, apart), in_column = median_step(y, false, apart);
  const bool by_rows = in_row >= in_column;

  const double largest = std::max(1.5 * stripe, steepest * std::max(in_row, in_column));
  const int length = by_rows ? y.width() : y.height();

  // 2. Along each line, stripe by stripe: pixels [begin, end) share one centre.
  for_each_row(by_rows ? y.height() : y.width(), [&](int line) {
    const auto at = [&](int i) -> double& { return by_rows ? y(i, line) : y(line, i); };

    double before = nan;
    for (int begin = 0, end = 0; begin < length; begin = end) {
      const double centre = at(begin);
      for (++end; end < length && at(end) == centre;) ++end;

      // Half the distance to the neighbouring stripe, which is where their common edge lies.
      const auto half_to = [&](double other) {
        return std::abs(other - centre) <= largest ? (other - centre) / 2 : nan;
      };
      double left = half_to(before), right = half_to(end < length ? at(end) : nan);

      if (std::isnan(left)) left = std::isnan(right) ? 0 : -right;
      if (std::isnan(right)) right = -left;

      for (int i = begin; i < end; ++i) {
        at(i) += std::lerp(left, right, (i - begin + 0.5) / (end - begin));
      }
      before = centre;
    }
  });
}

/// Projector coordinates that one camera sees along one axis.
struct Decoded {
  BasicMaps<double> maps{};  ///< coordinate NaN where invalid
  Image<Validity> validity{};
  Image<double> variance{};  ///< of the coordinate, fields^2
  double step = 0;           ///< median change from pixel to pixel, fields
};

Decoded decoded(const Scan& scan, EngineSetup setup) {
  // 1. The maps. They depend on sizes and photometry, not on the lenses.
  const PhotometricCalibration known = setup.scanner.photometry;
  setup.scanner = without_geometry(scan.frames.size(), scan.sequence.projector, known);
  setup.sequence = merged_sequence(scan.sequence);
  Maps maps;
  Engine(setup).maps(scan.frames, maps);

  // 2. Coordinates of the valid pixels alone.
  raise_least_modulation(setup);
  Decoded result;
  convert(maps, result.maps);
  result.validity = judged(result.maps, {}, scan.frames, setup);

  const Image<double>&mean = result.maps.mean, &modulation = result.maps.modulation;
  Image<double>& y = result.maps.coordinate;
  std::ranges::transform(y, result.validity, y.begin(), [](double at, Validity pixel) {
    return pixel == Validity::valid ? at : nan;
  });

  // 3. A code gives the centres of stripes: interpolate between their edges.
  const Layout& layout = setup.sequence.strategy.layout();
  const bool is_code = layout.unwrapping->whole_stripes;
  if (is_code) interpolate_stripes(y, 1 / layout.code->stripes);

  result.step = std::max(median_step(y, true), median_step(y, false));

  // 4. The variance of the coordinate: of sinusoids from the noise and the modulation.
  const double unit = coordinate_variance(layout, 1, 1);
  const double noise = cue_settings(setup).noise_variance;
  const double grey_level = scan.frames.full_scale() / 255;
  // An interpolated stripe is as exact as the pixels that find its edges.
  const double of_code = std::min(unit, result.step * result.step / 12);

  result.variance = Image<double>(y.size());
  std::ranges::transform(mean, modulation, result.variance.begin(), [&](double A, double B) {
    if (is_code) return of_code;
    return unit * noise_variance_at(A / grey_level, noise, known.noise_gain) *
           std::pow(grey_level / B, 2);
  });

  return result;
}

/// A place between three pixels of the second camera.
struct Place {
  std::array<int, 3> pixels{};
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< of the pixels
  double cotangent = nan;                             ///< of the ray
  double reach = 0;                                   ///< range of the pixels' cotangents
  double slope = 0;                                   ///< of the cotangent over the coordinate

  [[nodiscard]] Eigen::Vector3d of(const Image<double>& image) const {
    return {image.begin()[pixels[0]], image.begin()[pixels[1]], image.begin()[pixels[2]]};
  }
};

/// The place in a triangle of pixels with this epipolar angle and coordinate, if any.
Place place_in(const std::array<int, 3>& pixels, const Image<EpipolarRay>& rays,
               const Image<double>& coordinate, const Eigen::Vector2d& wanted) {
  // Columns: angle, coordinate and 1 of each corner, so that the inverse gives barycentric weights.
  Eigen::Matrix3d corners;
  Eigen::RowVector3d cotangents;
  for (int i = 0; i < 3; ++i) {
    const EpipolarRay& ray = rays.begin()[pixels[i]];
    corners.col(i) << ray.angle, coordinate.begin()[pixels[i]], 1;
    cotangents[i] = ray.cotangent;
  }

  const Eigen::Matrix3d inverse = corners.inverse();
  const Eigen::Vector3d weights = inverse * wanted.homogeneous();
  if (!(weights.array() >= 0).all()) return {};  // also if the triangle has no area

  // The cotangent is linear in the triangle too; its slope is taken at a fixed epipolar angle.
  return {pixels, weights, cotangents * weights, cotangents.maxCoeff() - cotangents.minCoeff(),
          cotangents * inverse.col(1)};
}

/// The cells between four neighbouring pixels, listed by epipolar angle and coordinate.
class CellIndex {
 public:
  /// Leaves out cells with an invalid pixel or a change of the coordinate above `largest`.
  CellIndex(const Image<EpipolarRay>& rays, const Image<double>& y, double largest)
      : rays_(rays),
        y_(y),
        bins_(static_cast<int>(std::sqrt(y.pixel_count()))),
        heads_(bins_ * bins_, -1) {
    // 1. The range of all places, which the bins divide.
    const auto place = [&](int i) { return Eigen::Vector2d(rays.begin()[i].angle, y.begin()[i]); };
    for (int i = 0; i < static_cast<int>(y.pixel_count()); ++i) {
      if (!place(i).hasNaN()) all_.extend(place(i));
    }

    // 2. Each cell goes into all bins that its bounding box touches.
    constexpr double turned = 1;  // rad: beside the epipole
    for (int i = 0; i < (y.height() - 1) * y.width() - 1; ++i) {
      Eigen::Matrix<double, 2, 4> corners;
      corners << place(i), place(i + 1), place(i + y.width()), place(i + y.width() + 1);
      if (corners.hasNaN() || i % y.width() == y.width() - 1) continue;

      const Eigen::Vector2d least = corners.rowwise().minCoeff(),
                            most = corners.rowwise().maxCoeff();
      if (most.x() - least.x() > turned || most.y() - least.y() > largest) continue;

      // A bin is a list: the newest entry is its head.
      for (int a = bin(least).x(); a <= bin(most).x(); ++a) {
        for (int b = bin(least).y(); b <= bin(most).y(); ++b) {
          entries_.push_back({i, heads_[a * bins_ + b]});
          heads_[a * bins_ + b] = static_cast<int>(entries_.size()) - 1;
        }
      }
    }
  }

  /// Visits each place with this epipolar angle and coordinate.
  void for_each_place(const Eigen::Vector2d& wanted, const auto& visit) const {
    if (!all_.contains(wanted)) return;

    const Eigen::Vector2i at = bin(wanted);
    for (int i = heads_[at.x() * bins_ + at.y()]; i >= 0; i = entries_[i].next) {
      const int cell = entries_[i].cell, below = cell + y_.width();

      // Two triangles, either side of the diagonal from top right to bottom left.
      for (const int corner : {cell, below + 1}) {
        visit(place_in({corner, cell + 1, below}, rays_, y_, wanted));
      }
    }
  }

 private:
  [[nodiscard]] Eigen::Vector2i bin(const Eigen::Vector2d& place) const {
    // All coordinates of a single stripe are the same.
    constexpr double least_size = std::numeric_limits<double>::min();
    const Eigen::Vector2d share =
        (place - all_.min()).cwiseQuotient(all_.sizes().cwiseMax(least_size));
    return (share * bins_).cast<int>().cwiseMin(bins_ - 1);
  }

  struct Entry {
    int cell, next;  ///< `next` of the same bin; -1 at the end
  };

  const Image<EpipolarRay>& rays_;
  const Image<double>& y_;
  int bins_;
  std::vector<int> heads_;
  std::vector<Entry> entries_;
  Eigen::AlignedBox2d all_;
};

/// Projector coordinates that both cameras see: along the axis to match, and the other if given.
struct SeenByBoth {
  Decoded first, second;
  std::optional<std::pair<Decoded, Decoded>> other{};
  bool is_across = false;  ///< the axis to match is not the scan's own

  /// The first camera's, along the scan's own axis.
  [[nodiscard]] const BasicMaps<double>& own_maps() const {
    return (is_across ? other->first : first).maps;
  }
};

SeenByBoth seen_by_both(const Scan& scan, const Scan& further, const EngineSetup& setup) {
  SeenByBoth seen{decoded(scan, setup), decoded(further, setup)};
  if (scan.other_axis.empty() || further.other_axis.empty()) return seen;

  seen.other.emplace(decoded(scan.other_axis.front(), setup),
                     decoded(further.other_axis.front(), setup));

  // The axis whose coordinate changes more along the epipolar lines, which run roughly along the
  // baseline, is matched; the other one checks.
  const Eigen::Vector3d along = setup.scanner.translation.cwiseAbs();
  const auto change = [&](const Decoded& camera) {
    return median_step(camera.maps.coordinate, along.x() >= along.y());
  };

  seen.is_across = change(seen.other->second) > change(seen.second);
  if (seen.is_across) {
    std::swap(seen.first, seen.other->first);
    std::swap(seen.second, seen.other->second);
  }

  return seen;
}

/// Whether the other axis excludes a place for pixel i of the first camera.
bool contradicts(const SeenByBoth& seen, const Place& place, int i) {
  if (!seen.other) return false;
  const auto& [first, second] = *seen.other;

  // Two pixels of the second camera, and five standard deviations, both cameras being as noisy as
  // the first.
  const double apart =
      place.weights.dot(place.of(second.maps.coordinate)) - first.maps.coordinate.begin()[i];
  return std::abs(apart) > 2 * second.step + 5 * std::sqrt(2 * first.variance.begin()[i]);
}

/// Where a pixel of the first camera is seen in the second, or why nowhere.
struct Match {
  Validity validity = Validity::no_point;
  Place place{};

  /// Takes one more place, of depth Z.
  void take(const Place& other, double Z, const DepthRange& depths) {
    // Ignore a place behind the camera. Once two places match, no further one can decide.
    if (!(Z > 0) || validity == Validity::doubtful_order) return;

    if (Z < depths.nearest || Z > depths.farthest) {
      if (validity == Validity::no_point) validity = Validity::out_of_range;
      return;
    }

    // Noise makes a coordinate turn back, but within a few pixels.
    const bool is_other = std::abs(other.cotangent - place.cotangent) > 3 * other.reach;
    validity = is_other ? Validity::doubtful_order : Validity::valid;

    // The same place in a neighbouring triangle: take the mean.
    const double before = std::isnan(place.cotangent) ? other.cotangent : place.cotangent;
    place = other;
    place.cotangent = (before + other.cotangent) / 2;
  }
};

/// The ray of a pixel of the first camera.
struct FirstRay {
  Eigen::Vector3d at_1;  ///< its point at 1 mm from the baseline
  double cotangent;      ///< of its angle to the baseline
  double scale;          ///< depth, times the difference of the cotangents

  /// Where it meets the ray of the second camera through this place.
  [[nodiscard]] double depth(const Place& place) const {
    return scale / (cotangent - place.cotangent);
  }
};

/// `frame`: in which the epipolar rays are given. `baseline`: its length, mm.
FirstRay first_ray(const EpipolarRay& ray, const Eigen::Matrix3d& frame, double baseline) {
  const Eigen::Vector3d in_frame(ray.cotangent, std::cos(ray.angle), std::sin(ray.angle));
  const Eigen::Vector3d at_1 = frame.transpose() * in_frame;
  return {at_1, ray.cotangent, baseline * at_1.z()};
}

/// Depth of a match, with the noise of both coordinates.
struct MatchedDepth {
  double Z;
  double variance;  ///< of the coordinate, fields^2
  double sigma;     ///< standard deviation of Z, over Z
};

MatchedDepth matched_depth(const FirstRay& ray, const Place& place, double first_variance,
                           const Image<double>& second_variance) {
  const double Z = ray.depth(place);
  const double variance = first_variance + place.weights.cwiseAbs2().dot(place.of(second_variance));
  const double sigma = Z / ray.scale * std::abs(place.slope) * std::sqrt(variance);

  return {Z, variance, sigma};
}

void store_point(const FirstRay& ray, const MatchedDepth& depth, int column, int row, Cloud& cloud,
                 Uncertainty& uncertainty) {
  const std::array point{&cloud.x, &cloud.y, &cloud.z};
  const std::array deviation{&uncertainty.x, &uncertainty.y, &uncertainty.z};

  uncertainty.coordinate(column, row) = static_cast<float>(std::sqrt(depth.variance));
  for (int i = 0; i < 3; ++i) {
    const double value = depth.Z / ray.at_1.z() * ray.at_1[i];
    (*point[i])(column, row) = static_cast<float>(value);
    (*deviation[i])(column, row) = static_cast<float>(depth.sigma * std::abs(value));
  }
  uncertainty.z_of_noise(column, row) = uncertainty.z(column, row);
}

}  // namespace

CoordinateMatcher::CoordinateMatcher(const Scanner& pair, const Sequence& sequence,
                                     const ReconstructSettings& settings)
    : setup_{pair, sequence, settings} {
  // 1. Settings; the second camera's response is unknown here.
  require_valid(pair);
  throw_if(!has_coordinate(sequence.strategy),
           "{}: its frames alone give only a wrapped phase; without a calibrated projector use a "
           "strategy that unwraps: {}",
           sequence.strategy.name(), fmt::join(names_with_coordinate(), ", "));
  setup_.scanner.photometry.response.reset();

  // 2. A frame with its first axis along the baseline: a ray's angle about that axis is its
  //    epipolar plane. If the baseline runs along Z, any direction across it will do.
  const Eigen::Vector3d along = projector_centre(pair).normalized();
  const Eigen::Vector3d across = along.cross(Eigen::Vector3d::UnitZ());
  frame_.row(0) = along;
  frame_.row(2) = across.norm() > 1e-6 ? across.normalized() : along.unitOrthogonal();
  frame_.row(1) = frame_.row(2).cross(frame_.row(0));

  // 3. The rays of both cameras in that frame.
  first_ = epipolar_rays(pair.camera, frame_);
  second_ = epipolar_rays(pair.projector, frame_ * pair.rotation.transpose());
}

CoordinateMatcher::Result CoordinateMatcher::operator()(const Scan& scan) const {
  throw_if(scan.further_cameras.empty(), "matching requires the scan of a second camera");
  const Scan& further = scan.further_cameras.front();
  require_size(scan.frames, first_.size());
  require_size(further.frames, second_.size());

  // 1. Decode both cameras, and list the second one's cells by angle and coordinate.
  const SeenByBoth seen = seen_by_both(scan, further, setup_);
  const Decoded &first = seen.first, &second = seen.second;
  const CellIndex cells(second_, second.maps.coordinate, steepest * second.step);

  const double baseline = setup_.scanner.translation.norm();
  const DepthRange depths = depth_range(setup_);
  const double grey_level = scan.frames.full_scale() / 255;

  const auto match_of = [&](int column, int row, const FirstRay& ray) {
    Match match;
    const Eigen::Vector2d wanted(first_(column, row).angle, first.maps.coordinate(column, row));
    cells.for_each_place(wanted, [&](const Place& place) {
      if (contradicts(seen, place, row * first_.width() + column)) return;
      match.take(place, ray.depth(place), depths);
    });
    return match;
  };

  // 2. Points: where epipolar angle and coordinate agree.
  Result result{.cloud = Cloud(first_.size()), .uncertainty = Uncertainty(first_.size())};
  auto& [cloud, maps, uncertainty] = result;
  for_each_pixel(first_.size(), [&](int column, int row) {
    Validity& validity = cloud.validity(column, row) = first.validity(column, row);
    cloud.intensity(column, row) = static_cast<float>(first.maps.mean(column, row) / grey_level);
    if (validity != Validity::valid) return;

    const FirstRay ray = first_ray(first_(column, row), frame_, baseline);
    const Match match = match_of(column, row, ray);
    validity = match.validity;
    if (validity != Validity::valid) return;

    // Without a setting, a deviation of up to 3 % of the depth.
    const MatchedDepth depth =
        matched_depth(ray, match.place, first.variance(column, row), second.variance);
    const double largest = setup_.settings.clean.largest_sigma.value_or(0.03 * depth.Z);
    if (depth.sigma * depth.Z > largest) {
      validity = Validity::low_trust;
      return;
    }

    store_point(ray, depth, column, row, cloud, uncertainty);
  });

  // 3. Clean the cloud.
  Cleaner(setup_.settings.clean)(cloud);
  convert(seen.own_maps(), maps);

  return result;
}

}  // namespace slipstream
