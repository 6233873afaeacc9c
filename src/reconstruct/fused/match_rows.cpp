// Matches of two cameras along epipolar lines, and comparison of their phases at given points.
#include "reconstruct/fused/match_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "reconstruct/fused/rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruct/fused/match_rows.cpp"
#include <hwy/foreach_target.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/epipolar_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// Matches of a vector of pixels, see PixelMatches.
struct Matches {
  Floats w;
  Pairs at;
  Floats speed, slope;

  HWY_INLINE void take(FloatMask where, const Matches& other) {
    w = hn::IfThenElse(where, other.w, w);
    at.x = hn::IfThenElse(where, other.at.x, at.x);
    at.y = hn::IfThenElse(where, other.at.y, at.y);
    speed = hn::IfThenElse(where, other.speed, speed);
    slope = hn::IfThenElse(where, other.slope, slope);
  }

  /// Whether there is a match: w is positive and finite.
  [[nodiscard]] HWY_INLINE FloatMask found() const {
    const FloatTag d;
    return hn::And(hn::Gt(w, hn::Zero(d)), hn::IsFinite(w));
  }
};

HWY_INLINE Matches no_matches() {
  return {nans(), {nans(), nans()}, nans(), nans()};
}

/// An epipolar line at a place: the pixel's change over w is a direction of length 1, times speed.
struct Tangents {
  Pairs direction;
  Floats speed;
};

/// Searches along the epipolar lines of a vector of pixels.
class LineSearch {
 public:
  HWY_INLINE LineSearch(const Rays& rays, const CameraPhases& first, const CameraPhases& second,
                        Ints pixels)
      : rays_(rays), first_(first), second_(second), pixels_(pixels) {}

  /// Phase of band i in the second camera less that in the first, rad; NaN beside an invalid pixel.
  HWY_INLINE Floats difference(std::size_t i, Pairs place) const {
    return angle_between(SeenBand(second_, i).at(place), own(i));
  }
  HWY_INLINE Floats near_difference(std::size_t i, Pairs place) const {
    return angle_between(SeenBand(second_, i).near(place), own(i));
  }

  /// The agreement of band i nearest to `start` by Newton's method; not found unless it converges
  /// within `farthest` pixels.
  HWY_INLINE Matches by_newton(std::size_t i, Floats start, int farthest) const {
    constexpr int most_steps = 4;
    constexpr float near = 0.01F;  // rad: the last step's error is of second order

    const FloatTag d;
    Pairs at = rays_.place(start);
    const Tangents line = tangents(start, at);
    const Floats limit = hn::Div(hn::Set(d, static_cast<float>(farthest)), line.speed);

    Matches found = no_matches();
    FloatMask open = hn::Gt(start, hn::Zero(d));
    Floats w = start, along = nans();

    for (int n = 0; n < most_steps; ++n) {
      const Floats apart = difference(i, at);

      // The slope changes less than the phase: every other step reuses the last slope.
      if (n % 2 == 0) along = slope(i, at, line.direction);

      const Floats step = hn::Neg(hn::Div(apart, hn::Mul(along, line.speed)));
      w = hn::Add(w, step);
      open = hn::And(open, hn::Le(hn::Abs(hn::Sub(w, start)), limit));  // not of NaN

      const FloatMask done = hn::And(open, hn::Lt(hn::Abs(apart), hn::Set(d, near)));
      const Pairs end = added(at, hn::Mul(step, line.speed), line.direction);
      found.take(done, {w, end, line.speed, along});

      open = hn::AndNot(done, open);
      if (hn::AllFalse(d, open)) break;
      at = rays_.place(w);
    }

    return found;
  }

  /// The same by trying one place after the other, `stride` pixels apart.
  HWY_INLINE Matches by_places(std::size_t i, Floats start, int farthest, int stride) const {
    const FloatTag d;
    const Pairs begin = rays_.place(start);
    const Tangents line = tangents(start, begin);
    const Floats step = hn::Div(hn::Set(d, static_cast<float>(stride)), line.speed);

    const auto difference_at = [&](Floats w) HWY_ATTR {
      if (stride == 1) return difference(i, rays_.place(w));
      // A coarse phase hardly changes over the pixel or two by which the line is not straight.
      const Floats pixels = hn::Mul(hn::Sub(w, start), line.speed);
      return near_difference(i, added(begin, pixels, line.direction));
    };

    // Outwards from the start on both sides, until the phases agree on one of them.
    Floats nearest = nans(), distance = hn::Set(d, std::numeric_limits<float>::infinity());
    FloatMask open = hn::IsFinite(step);
    Several<2> before;
    before[0] = before[1] = difference_at(start);

    for (int n = 1; n * stride <= farthest; ++n) {
      for (const int side : {0, 1}) {
        const Floats sign = hn::Set(d, side == 0 ? -1.0F : 1.0F);
        const auto place = [&](int k) HWY_ATTR {
          return hn::MulAdd(hn::Mul(sign, hn::Set(d, static_cast<float>(k))), step, start);
        };
        const Floats last = place(n - 1), next = place(n), apart = difference_at(next);

        // At a full turn the sign changes too, but with a jump.
        const Floats rise = hn::Sub(apart, before[side]);
        const FloatMask is_smooth =
            hn::Le(hn::Abs(rise), hn::Set(d, std::numbers::pi_v<float> / 2));
        const FloatMask agrees =
            hn::And(hn::And(open, is_smooth), hn::Le(hn::Mul(before[side], apart), hn::Zero(d)));

        if (!hn::AllFalse(d, agrees)) {
          const Floats w = between(last, next, before[side], apart, difference_at);
          const Floats away = hn::Abs(hn::Sub(w, start));
          const FloatMask nearer = hn::And(agrees, hn::Lt(away, distance));
          nearest = hn::IfThenElse(nearer, w, nearest);
          distance = hn::IfThenElse(nearer, away, distance);
        }
        before[side] = apart;
      }

      open = hn::And(open, hn::IsNaN(nearest));
      if (hn::AllFalse(d, open)) break;
    }

    const Pairs at = rays_.place(nearest);
    const Tangents end = tangents(nearest, at);
    return {nearest, at, end.speed, slope(i, at, end.direction)};
  }

  /// By Newton's method, or else by trying places.
  HWY_NOINLINE Matches search(std::size_t i, Floats start, int reach, int stride) const {
    const FloatTag d;
    Matches match = by_newton(i, start, reach);
    const FloatMask missing = hn::Not(match.found());
    if (!hn::AllFalse(d, missing)) match.take(missing, by_places(i, start, reach, stride));
    return match;
  }

 private:
  HWY_INLINE Pairs own(std::size_t i) const {
    return gather(reinterpret_cast<const float*>(first_.bands[i].begin()), pixels_);
  }

  HWY_INLINE Tangents tangents(Floats w, Pairs at) const {
    const FloatTag d;
    const Floats step = hn::Mul(hn::Set(d, 1e-3F), w);
    const Pairs next = rays_.place(hn::Add(w, step));
    const Floats x = hn::Sub(next.x, at.x), y = hn::Sub(next.y, at.y);
    const Floats length = hn::Sqrt(hn::MulAdd(x, x, hn::Mul(y, y)));
    return {{hn::Div(x, length), hn::Div(y, length)}, hn::Div(length, step)};
  }

  /// Change of the phase of band i at a place, over one pixel in that direction: a central
  /// difference over two.
  HWY_INLINE Floats slope(std::size_t i, Pairs at, Pairs direction) const {
    const FloatTag d;
    const SeenBand band(second_, i);
    const Pairs before = band.near(added(at, hn::Set(d, -1.0F), direction));
    const Pairs after = band.near(added(at, hn::Set(d, 1.0F), direction));
    const Floats rise = hn::Mul(hn::Set(d, 0.5F), angle_between(after, before));
    return hn::IfThenElse(hn::IsNaN(before.x), nans(), rise);
  }

  /// The agreement between two neighbouring places with these differences, whose signs differ.
  template <class Difference>
  HWY_INLINE Floats between(Floats near, Floats far, Floats d_near, Floats d_far,
                            const Difference& difference_at) const {
    const FloatTag d;
    const auto crossing = [&](Floats a, Floats b, Floats d_a, Floats d_b) SLIPSTREAM_STEP {
      const Floats fall = hn::Sub(d_a, d_b);
      const Floats part = hn::IfThenZeroElse(hn::Eq(fall, hn::Zero(d)), hn::Div(d_a, fall));
      return hn::MulAdd(part, hn::Sub(b, a), a);
    };
    const Floats w = crossing(near, far, d_near, d_far), apart = difference_at(w);

    // The phase is not linear between two places: interpolate again where the sign changes.
    const FloatMask is_before = hn::Le(hn::Mul(apart, d_near), hn::Zero(d));
    const Floats again =
        hn::IfThenElse(is_before, crossing(near, w, d_near, apart), crossing(w, far, apart, d_far));
    return hn::IfThenElse(hn::IsNaN(apart), w, again);
  }

  const Rays& rays_;
  const CameraPhases &first_, &second_;
  Ints pixels_;
};

/// One fringe further a fine phase agrees again, but the coarser one does not.
HWY_INLINE FloatMask is_in_fringe(const LineSearch& line, const BandSearch& bands, std::size_t i,
                                  Pairs at) {
  const FloatTag d;
  const Floats apart = line.near_difference(i - 1, at);
  return hn::Lt(hn::Abs(apart), hn::Set(d, bands.fringes[i] / 3));
}

/// Search range around the coarse match, which is good to a few pixels.
constexpr int fine_reach = 12;

/// The agreement of the finest band nearest to the guess, confirmed by the coarser ones. The
/// projector coordinate is mostly right to a part of a fringe.
HWY_NOINLINE Matches near_match(const LineSearch& line, const BandSearch& bands, Floats guess) {
  const std::size_t finest = bands.fringes.size() - 1;
  Matches match = line.by_newton(finest, guess, fine_reach);
  FloatMask confirmed = match.found();
  for (std::size_t i = finest; i > 0; --i)
    confirmed = hn::And(confirmed, is_in_fringe(line, bands, i, match.at));
  match.w = hn::IfThenElse(confirmed, match.w, nans());
  return match;
}

/// Each band searched in turn: where the guess is off, because of gamma or at edges.
HWY_NOINLINE Matches band_match(const LineSearch& line, const BandSearch& bands, Floats guess) {
  const FloatTag d;
  Matches match = line.search(0, guess, bands.reach, bands.stride);
  for (std::size_t i = 1; i < bands.fringes.size(); ++i) {
    if (hn::AllFalse(d, match.found())) break;
    const Floats start = hn::IfThenElse(match.found(), match.w, nans());
    match = line.search(i, start, fine_reach, 1);
    match.w = hn::IfThenElse(is_in_fringe(line, bands, i, match.at), match.w, nans());
  }
  match.w = hn::IfThenElse(match.found(), match.w, nans());
  return match;
}

/// Finds matches of all pixels; `nearby`: only near the guess.
void find_matches(const EpipolarLines& lines, const CameraPhases& first, const CameraPhases& second,
                  const BandSearch& bands, bool nearby, PixelMatches& matches) {
  const FloatTag d;
  const IntTag di;
  for_each_vector(static_cast<int>(matches.pixels.size()), [&](std::size_t k) HWY_ATTR {
    const Ints pixels = hn::LoadU(di, matches.pixels.data() + k);
    const Rays rays(lines, pixels);
    const Floats y = hn::LoadU(d, matches.coordinates.data() + k);
    const Floats guess = rays.inverse_depth(y);
    const Floats beside = rays.inverse_depth(hn::Add(y, hn::Set(d, bands.quarter)));
    const Floats start = hn::IfThenElse(hn::Gt(guess, hn::Zero(d)), guess, nans());

    const LineSearch line(rays, first, second, pixels);
    const Matches found = nearby ? near_match(line, bands, start) : band_match(line, bands, start);
    hn::StoreU(found.w, d, matches.w.data() + k);
    hn::StoreU(found.at.x, d, matches.x.data() + k);
    hn::StoreU(found.at.y, d, matches.y.data() + k);
    hn::StoreU(found.speed, d, matches.speed.data() + k);
    hn::StoreU(found.slope, d, matches.slope.data() + k);

    const Floats quarters = quotient(hn::Sub(found.w, guess), hn::Sub(beside, guess));
    hn::StoreU(hn::Abs(quarters), d, matches.quarters.data() + k);
  });
}

void compare_points(const EpipolarLines& lines, const CameraPhases& first,
                    const CameraPhases& second, const DepthRange& depths, bool of_other,
                    PointPhases& points) {
  const FloatTag d;
  const IntTag di;
  const hn::RebindToUnsigned<IntTag> du;
  const SeenBand band(second, 0);
  const auto* const own = reinterpret_cast<const float*>(first.bands[0].begin());

  for_each_vector(static_cast<int>(points.pixels.size()), [&](std::size_t i) HWY_ATTR {
    const Ints counts = hn::LoadU(di, points.counts.data() + i);
    const int most = hn::GetLane(hn::MaxOfLanes(di, counts));
    if (most == 0) return;

    const Ints pixels = hn::LoadU(di, points.pixels.data() + i);
    const Ints slots =
        hn::Mul(hn::Iota(di, static_cast<std::int32_t>(i)), hn::Set(di, points.most));
    const Rays rays(lines, pixels);
    const Pairs reference = gather(own, pixels);
    Floats y = hn::LoadU(d, points.coordinates.data() + i);

    for (int k = 0; k < most; ++k) {
      // 1. The points, where they lie in the depth range.
      const Floats w = rays.inverse_depth(y);
      const FloatMask asked = hn::RebindMask(d, hn::Gt(counts, hn::Set(di, k)));
      const FloatMask possible = hn::And(asked, rays.is_between(w, depths, of_other));
      y = hn::Add(y, hn::Set(d, points.step));
      if (hn::AllFalse(d, possible)) continue;

      // 2. The angle of the product is the difference of the phases.
      const Pairs product = conjugate_product(band.near(rays.place(w)), reference);
      const Floats square = hn::MulAdd(product.x, product.x, hn::Mul(product.y, product.y));
      const Floats apart = hn::Sub(hn::Set(d, 1.0F), quotient(product.x, hn::Sqrt(square)));

      // 3. The votes.
      const FloatMask seen = hn::And(possible, hn::Eq(apart, apart));
      const Ints steps = hn::ConvertTo(di, hn::Mul(apart, hn::Set(d, 1 / Disagreement::step)));
      const Ints vote = hn::IfThenElseZero(hn::RebindMask(di, seen),
                                           hn::Add(steps, hn::Set(di, Disagreement::one_pixel)));
      hn::ScatterIndex(hn::BitCast(du, vote), du, points.votes.data() + k, slots);
    }
  });
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(find_matches);
HWY_EXPORT(compare_points);

namespace {

/// Repeats the last value until there are enough for a vector.
template <class Value>
void fill_vector(std::vector<Value>& values) {
  const Value last = values.back();
  values.resize(std::max<std::size_t>(values.size(), least_row_width), last);
}

}  // namespace

void match_pixels(const EpipolarLines& lines, const CameraPhases& first, const CameraPhases& second,
                  const BandSearch& bands, PixelMatches& matches) {
  const std::size_t count = matches.pixels.size();
  if (count == 0) return;

  constexpr std::array results{&PixelMatches::w,     &PixelMatches::x,     &PixelMatches::y,
                               &PixelMatches::speed, &PixelMatches::slope, &PixelMatches::quarters};
  const auto find = [&](bool nearby, PixelMatches& of) {
    fill_vector(of.pixels);
    fill_vector(of.coordinates);
    for (const auto result : results) (of.*result).resize(of.pixels.size());
    HWY_DYNAMIC_DISPATCH(find_matches)(lines, first, second, bands, nearby, of);
  };

  find(true, matches);

  // Only pixels without a match are searched farther: few, but each takes long.
  thread_local PixelMatches rest;
  rest.pixels.clear();
  rest.coordinates.clear();
  for (std::size_t k = 0; k < count; ++k) {
    if (!std::isnan(matches.w[k])) continue;
    rest.pixels.push_back(matches.pixels[k]);
    rest.coordinates.push_back(matches.coordinates[k]);
  }
  if (rest.pixels.empty()) return;

  find(false, rest);
  std::size_t next = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (!std::isnan(matches.w[k])) continue;
    for (const auto result : results) (matches.*result)[k] = (rest.*result)[next];
    ++next;
  }
}

void compare_phases(const EpipolarLines& lines, const CameraPhases& first,
                    const CameraPhases& second, const DepthRange& depths, bool of_other,
                    PointPhases& points) {
  if (points.pixels.empty()) return;
  fill_vector(points.pixels);
  fill_vector(points.coordinates);
  fill_vector(points.counts);
  points.votes.assign(points.pixels.size() * static_cast<std::size_t>(points.most), 0);
  HWY_DYNAMIC_DISPATCH(compare_points)(lines, first, second, depths, of_other, points);
}

}  // namespace slipstream
#endif
