#include "reconstruct/epipolar_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/numbers.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Search range in the second camera on either side of the place given by the projector, as a share
/// of the width; with gamma 3, three steps are off by a tenth of the field.
constexpr double coarse_reach = 0.15;
/// Search range around the coarse match, which is good to a few pixels.
constexpr int fine_reach = 12;

}  // namespace

float EpipolarSearch::slope(std::size_t i, const Eigen::Vector2f& at,
                            const Eigen::Vector2f& pixel) const {
  // Central difference over two pixels of the second camera.
  const Phasor before = near_phasor(second_, second_.bands[i], at - pixel);
  const Phasor after = near_phasor(second_, second_.bands[i], at + pixel);
  if (before == Phasor(0) || after == Phasor(0)) return std::numeric_limits<float>::quiet_NaN();
  return 0.5F * angle_of(after * std::conj(before));
}

EpipolarMatch EpipolarSearch::by_newton(std::size_t i, float start, int farthest) const {
  constexpr int most_steps = 4;
  constexpr float near = 0.01F;  // rad: the last step's error is of second order

  Eigen::Vector2f at = place(start);
  const Eigen::Vector2f direction = pixels_per_w(start, at);
  const float speed = direction.norm();  // pixels over w
  const float limit = static_cast<float>(farthest) / speed;

  float w = start, along = 0;
  for (int n = 0; n < most_steps; ++n) {
    const float d = difference(i, at);

    // The slope changes less than the phase: every other step takes the one of the step before.
    if (n % 2 == 0) along = slope(i, at, direction / speed);

    const float step = -d / (along * speed);
    if (!(std::abs(w + step - start) <= limit)) return {};  // NaN, too

    w += step;
    if (std::abs(d) < near) return {w, at + step * direction, direction, along};
    at = place(w);
  }

  return {};
}

EpipolarMatch EpipolarSearch::by_places(std::size_t i, float start, int farthest,
                                        int stride) const {
  const Eigen::Vector2f begin = place(start), direction = pixels_per_w(start, begin);
  const float step = static_cast<float>(stride) / direction.norm();
  if (!(step > 0) || !std::isfinite(step)) return {};

  const auto difference_at = [&](float w) {
    if (stride == 1) return difference(i, place(w));
    // A coarse phase hardly changes over the pixel or two by which the line is not straight.
    return near_difference(i, begin + (w - start) * direction);
  };

  /// The agreement between two neighbouring places with these differences, if any.
  const auto between = [&](float near, float far, float d_near, float d_far) {
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    // At a full turn the sign changes too, but with a jump.
    const bool jumps = std::abs(d_far - d_near) > std::numbers::pi_v<float> / 2;
    if (!(d_near * d_far <= 0) || jumps) return none;

    // The agreement by linear interpolation.
    const float w = std::lerp(near, far, d_near / (d_near - d_far));
    const float d = difference_at(w);
    if (!std::isfinite(d)) return w;

    // The phase is not linear between two places: interpolate again where the sign changes.
    if (d * d_near <= 0) return std::lerp(near, w, d_near == d ? 0 : d_near / (d_near - d));
    return std::lerp(w, far, d == d_far ? 0 : d / (d - d_far));
  };

  // Outwards from the start on both sides, until the phases agree on one of them.
  float nearest = std::numeric_limits<float>::quiet_NaN();
  float d_nearer = difference_at(start), d_farther = d_nearer;
  for (int n = 1; n * stride <= farthest && std::isnan(nearest); ++n) {
    for (const int side : {-1, 1}) {
      float& d_before = side < 0 ? d_nearer : d_farther;
      const float before = start + static_cast<float>(side * (n - 1)) * step;
      const float next = start + static_cast<float>(side * n) * step;
      const float d_next = difference_at(next);

      const float w = between(before, next, d_before, d_next);
      if (!(std::abs(w - start) >= std::abs(nearest - start)) && !std::isnan(w)) nearest = w;
      d_before = d_next;
    }
  }

  if (std::isnan(nearest)) return {};

  const Eigen::Vector2f at = place(nearest), along = pixels_per_w(nearest, at);
  return {nearest, at, along, slope(i, at, along.normalized())};
}

BandSearch band_search(const Layout& layout, int width) {
  BandSearch search;
  double before = 0;

  for (const std::size_t i : coarse_to_fine(layout)) {
    const double periods = layout.bands[i].periods;

    // Seen from the coarser band, a period of this one is a fraction of a turn.
    search.fringes.push_back(static_cast<float>(before == 0 ? two_pi : two_pi * before / periods));

    // The coarsest of several bands is searched widely, in steps of two hundredths of its period.
    if (before == 0 && layout.bands.size() > 1) {
      constexpr double little = 0.02;  // periods
      search.reach = static_cast<int>(coarse_reach * width);
      search.stride = std::clamp(static_cast<int>(little * width / periods), 1, 12);
    }

    before = periods;
  }

  return search;
}

EpipolarMatch match_pixel(const EpipolarSearch& line, float guess, const BandSearch& bands) {
  const std::size_t finest = bands.fringes.size() - 1;

  // One fringe further a fine phase agrees again, but the coarser one does not.
  const auto is_in_fringe = [&](std::size_t i, const EpipolarMatch& match) {
    return std::abs(line.near_difference(i - 1, match.at)) < bands.fringes[i] / 3;
  };

  // 1. The projector coordinate is mostly right to a part of a fringe, and the coarser bands then
  //    confirm the nearest agreement of the finest.
  const EpipolarMatch near = line.by_newton(finest, guess, fine_reach);
  bool confirmed = near.is_found();
  for (std::size_t i = finest; i > 0 && confirmed; --i) confirmed = is_in_fringe(i, near);
  if (confirmed) return near;

  // 2. Where it is not, because of gamma or at edges, each band is searched in turn.
  const auto search = [&](std::size_t i, float start, int reach, int stride) {
    const EpipolarMatch match = line.by_newton(i, start, reach);
    return match.is_found() ? match : line.by_places(i, start, reach, stride);
  };

  EpipolarMatch match = search(0, guess, bands.reach, bands.stride);
  for (std::size_t i = 1; i <= finest && match.is_found(); ++i) {
    match = search(i, match.w, fine_reach, 1);
    if (match.is_found() && !is_in_fringe(i, match)) return {};
  }

  return match;
}

}  // namespace slipstream
