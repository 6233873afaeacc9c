// Rays of one camera seen from another, and what that one sees there, several at a time. Included
// once per vector target.
#if defined(SLIPSTREAM_KERNELS_EPIPOLAR_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SLIPSTREAM_KERNELS_EPIPOLAR_RAYS_INL_H_
#undef SLIPSTREAM_KERNELS_EPIPOLAR_RAYS_INL_H_
#else
#define SLIPSTREAM_KERNELS_EPIPOLAR_RAYS_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "base/numbers.h"
#include "base/vectors-inl.h"
#include "reconstruct/epipolar_tables.h"
#include "reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// Pairs of numbers: x and y of places, or C and S of phasors.
struct Pairs {
  Floats x, y;
};

HWY_INLINE Pairs gather(const float* pairs, Ints index) {
  const FloatTag d;

#if HWY_TARGET == HWY_SCALAR
  const Ints twice = hn::ShiftLeft<1>(index);
  return {hn::GatherIndex(d, pairs, twice), hn::GatherIndex(d, pairs + 1, twice)};
#else
  // Each pair is loaded as one number of 64 bits: half as many loads.
  const hn::Repartition<double, FloatTag> wide;
  const hn::RebindToSigned<decltype(wide)> wide_index;
  const hn::Half<IntTag> half;

  const auto* const whole = reinterpret_cast<const double*>(pairs);
  const auto gathered = [&](auto part) SLIPSTREAM_STEP {
    return hn::BitCast(d, hn::GatherIndex(wide, whole, hn::PromoteTo(wide_index, part)));
  };
  const Floats low = gathered(hn::LowerHalf(half, index));
  const Floats high = gathered(hn::UpperHalf(half, index));
  return {hn::ConcatEven(d, high, low), hn::ConcatOdd(d, high, low)};
#endif
}

/// a + t b
HWY_INLINE Pairs added(Pairs a, Floats t, Pairs b) {
  return {hn::MulAdd(t, b.x, a.x), hn::MulAdd(t, b.y, a.y)};
}

HWY_INLINE Pairs mixed(Pairs a, Pairs b, Floats t) {
  return added(a, t, {hn::Sub(b.x, a.x), hn::Sub(b.y, a.y)});
}

/// a conj(b)
HWY_INLINE Pairs conjugate_product(Pairs a, Pairs b) {
  return {hn::MulAdd(a.x, b.x, hn::Mul(a.y, b.y)), hn::MulSub(a.y, b.x, hn::Mul(a.x, b.y))};
}

/// Angle of a conj(b), rad, -pi to pi; NaN if a is.
HWY_INLINE Floats angle_between(Pairs a, Pairs b) {
  const FloatTag d;
  const Pairs product = conjugate_product(a, b);
  Several<1> cosine, sine;
  cosine[0] = product.x;
  sine[0] = product.y;

  const Floats turns = angles_in_turns<1>(sine, cosine)[0];
  const Floats angle =
      hn::Mul(hn::Sub(turns, hn::Round(turns)), hn::Set(d, static_cast<float>(two_pi)));
  return hn::IfThenElse(hn::IsNaN(a.x), a.x, angle);
}

/// Pixels beside a place.
struct Corner {
  FloatMask inside;     ///< there are `margin` further pixels on every side
  Ints index;           ///< of the pixel left above
  Floats right, below;  ///< distances from it
};

HWY_INLINE Corner corner_of(Size size, Pairs at, int margin) {
  const FloatTag d;
  const IntTag di;
  const auto within = [&](Floats v, int length) SLIPSTREAM_STEP {
    return hn::And(hn::Ge(v, hn::Set(d, static_cast<float>(margin))),
                   hn::Lt(v, hn::Set(d, static_cast<float>(length - 1 - margin))));
  };
  const FloatMask inside = hn::And(within(at.x, size.width), within(at.y, size.height));

  // Other places become one that is inside, whose pixels exist if any place is inside.
  const Floats safe = hn::Set(d, static_cast<float>(margin));
  const Floats x = hn::IfThenElse(inside, at.x, safe), y = hn::IfThenElse(inside, at.y, safe);
  const Ints left = hn::ConvertTo(di, x), top = hn::ConvertTo(di, y);

  return {inside, hn::Add(left, hn::Mul(top, hn::Set(di, size.width))),
          hn::Sub(x, hn::ConvertTo(d, left)), hn::Sub(y, hn::ConvertTo(d, top))};
}

HWY_INLINE Pairs bilinear(const float* pairs, int width, const Corner& corner) {
  const IntTag di;
  const auto row = [&](Ints index) SLIPSTREAM_STEP {
    return mixed(gather(pairs, index), gather(pairs + 2, index), corner.right);
  };
  return mixed(row(corner.index), row(hn::Add(corner.index, hn::Set(di, width))), corner.below);
}

/// Cubic convolution weights (Keys) of the four pixels around a position, `t` past the second.
HWY_INLINE Several<4> cubic_weights(Floats t) {
  const FloatTag d;
  const Floats one = hn::Set(d, 1.0F), u = hn::Sub(one, t);
  const Floats half = hn::Mul(hn::Set(d, -0.5F), hn::Mul(t, u));
  const auto inner = [&](Floats v) SLIPSTREAM_STEP {
    const Floats slope = hn::MulSub(hn::Set(d, 1.5F), v, hn::Set(d, 2.5F));
    return hn::MulAdd(hn::Mul(v, v), slope, one);
  };

  Several<4> weights;
  weights[0] = hn::Mul(half, u);
  weights[1] = inner(t);
  weights[2] = inner(u);
  weights[3] = hn::Mul(half, t);
  return weights;
}

/// A band of the second camera.
class SeenBand {
 public:
  HWY_INLINE SeenBand(const CameraPhases& camera, std::size_t i)
      : pairs_(reinterpret_cast<const float*>(camera.bands[i].begin())),
        surrounded_(camera.surrounded.begin()),
        size_(camera.surrounded.size()) {}

  /// Interpolated phasors; NaN beside an invalid pixel, or beyond the picture.
  HWY_INLINE Pairs at(Pairs place) const {
    const FloatTag d;
    const IntTag di;
    const Corner corner = corner_of(size_, place, 1);
    const FloatMask seen = seen_at(corner);
    if (hn::AllFalse(d, seen)) return {nans(), nans()};

    const Several<4> across = cubic_weights(corner.right), down = cubic_weights(corner.below);
    Pairs sum{hn::Zero(d), hn::Zero(d)};
    for (int j = 0; j < 4; ++j) {
      const Ints first = hn::Add(corner.index, hn::Set(di, (j - 1) * size_.width - 1));
      Pairs row{hn::Zero(d), hn::Zero(d)};
      for (int i = 0; i < 4; ++i) row = added(row, across[i], gather(pairs_ + 2 * i, first));
      sum = added(sum, down[j], row);
    }
    return {hn::IfThenElse(seen, sum.x, nans()), hn::IfThenElse(seen, sum.y, nans())};
  }

  /// The same from the four nearest pixels: biased where the phase bends.
  HWY_INLINE Pairs near(Pairs place) const {
    const FloatTag d;
    const Corner corner = corner_of(size_, place, 0);
    const FloatMask seen = seen_at(corner);
    if (hn::AllFalse(d, seen)) return {nans(), nans()};

    const Pairs mean = bilinear(pairs_, size_.width, corner);
    return {hn::IfThenElse(seen, mean.x, nans()), hn::IfThenElse(seen, mean.y, nans())};
  }

 private:
  HWY_INLINE FloatMask seen_at(const Corner& corner) const {
    const FloatTag d;
    const IntTag di;
    if (hn::AllFalse(d, corner.inside)) return corner.inside;
    const Ints valid = hn::GatherIndex(di, surrounded_, corner.index);
    return hn::And(corner.inside, hn::RebindMask(d, hn::Ne(valid, hn::Zero(di))));
  }

  const float* pairs_;
  const std::int32_t* surrounded_;
  Size size_;
};

/// The rays of some pixels of the first camera, seen from the second.
class Rays {
 public:
  HWY_INLINE Rays(const EpipolarLines& lines, Ints pixels) : lines_(lines) {
    const FloatTag d;
    const IntTag di;
    static_assert(sizeof(EpipolarLines::Ray) == (3 + EpipolarLines::terms) * sizeof(float));
    const auto* const numbers = reinterpret_cast<const float*>(lines.rays.begin());
    const Ints first = hn::Mul(pixels, hn::Set(di, sizeof(EpipolarLines::Ray) / sizeof(float)));
    for (int k = 0; k < 3; ++k) turned_[k] = hn::GatherIndex(d, numbers + k, first);
    for (int k = 0; k < EpipolarLines::terms; ++k)
      depth_[k] = hn::GatherIndex(d, numbers + 3 + k, first);
  }

  /// See EpipolarTables.
  HWY_INLINE Floats inverse_depth(Floats y) const {
    const FloatTag d;
    const float scale = 1 / (0.5F - EpipolarLines::least_y);
    const Floats p = hn::Mul(hn::Sub(y, hn::Set(d, 0.5F)), hn::Set(d, scale));
    Floats w = depth_[EpipolarLines::terms - 1];
    for (int k = EpipolarLines::terms - 2; k >= 0; --k) w = hn::MulAdd(w, p, depth_[k]);
    return w;
  }

  /// The point's pixel in the second camera; NaN behind it.
  HWY_INLINE Pairs place(Floats w) const {
    const FloatTag d;
    const auto along = [&](int k) SLIPSTREAM_STEP {
      return hn::MulAdd(w, hn::Set(d, lines_.translation[k]), turned_[k]);
    };
    Floats Z = along(2);
    Z = hn::IfThenElse(hn::Gt(Z, hn::Zero(d)), Z, nans());
    Pairs bent{quotient(along(0), Z), quotient(along(1), Z)};
    if (!lines_.straight) bent = bent_by_lens(bent);

    const auto on_sensor = [&](int k) SLIPSTREAM_STEP {
      const auto entry = [&](int i) SLIPSTREAM_STEP { return hn::Set(d, lines_.sensor(k, i)); };
      return hn::MulAdd(bent.x, entry(0), hn::MulAdd(bent.y, entry(1), entry(2)));
    };
    Pairs pixel{on_sensor(0), on_sensor(1)};
    if (lines_.tilted) {
      const Floats scale = on_sensor(2);
      pixel = {hn::Div(pixel.x, scale), hn::Div(pixel.y, scale)};
    }

    if (!lines_.shifts.empty()) pixel = added(pixel, hn::Set(d, 1.0F), shift_near(pixel));
    return pixel;
  }

  /// Whether the point's Z lies between those depths, mm; in the second camera's frame if
  /// `of_other`.
  HWY_INLINE FloatMask is_between(Floats w, const DepthRange& depths, bool of_other) const {
    const FloatTag d;
    const Floats scale = of_other ? turned_[2] : hn::Set(d, 1.0F);
    const double offset = of_other ? lines_.translation.z() : 0;

    // Z = scale / w + offset, without the division.
    const auto reach = [&](double depth) SLIPSTREAM_STEP {
      return hn::Mul(w, hn::Set(d, static_cast<float>(depth - offset)));
    };
    const FloatMask is_past = hn::Gt(scale, reach(depths.nearest));
    const FloatMask is_before = hn::Lt(scale, reach(depths.farthest));
    return hn::And(hn::Gt(w, hn::Zero(d)), hn::And(is_past, is_before));
  }

 private:
  /// See distort_untilted.
  HWY_INLINE Pairs bent_by_lens(Pairs at) const {
    const FloatTag d;
    const auto k = [&](int i) SLIPSTREAM_STEP { return hn::Set(d, lines_.lens[i]); };
    const Floats one = hn::Set(d, 1.0F), two = hn::Set(d, 2.0F);
    const Floats r2 = hn::MulAdd(at.x, at.x, hn::Mul(at.y, at.y));
    const auto series = [&](int a, int b, int c) SLIPSTREAM_STEP {
      return hn::MulAdd(r2, hn::MulAdd(r2, hn::MulAdd(r2, k(c), k(b)), k(a)), one);
    };
    const Floats radial = hn::Div(series(0, 1, 4), series(5, 6, 7));
    const Floats both = hn::Mul(two, hn::Mul(at.x, at.y));

    const auto bent = [&](Floats v, Floats p, Floats q, int s) SLIPSTREAM_STEP {
      const Floats square = hn::MulAdd(hn::Mul(two, v), v, r2);
      const Floats prism = hn::Mul(r2, hn::MulAdd(r2, k(s + 1), k(s)));
      return hn::MulAdd(v, radial, hn::MulAdd(p, both, hn::MulAdd(q, square, prism)));
    };
    return {bent(at.x, k(2), k(3), 8), bent(at.y, k(3), k(2), 10)};
  }

  /// Bilinear interpolation; beyond the picture the shift of its rim.
  HWY_INLINE Pairs shift_near(Pairs at) const {
    const FloatTag d;
    const Size size = lines_.shifts.size();
    const auto held = [&](Floats v, int length) SLIPSTREAM_STEP {
      // Just inside the last pixel; NaN becomes 0.
      const Floats last = hn::Set(d, static_cast<float>(length - 1) * (1 - 1e-6F));
      const Floats known = hn::IfThenElse(hn::IsNaN(v), hn::Zero(d), v);
      return hn::Clamp(known, hn::Zero(d), last);
    };
    const Corner corner = corner_of(size, {held(at.x, size.width), held(at.y, size.height)}, 0);
    const auto* const pairs = reinterpret_cast<const float*>(lines_.shifts.begin());
    return bilinear(pairs, size.width, corner);
  }

  const EpipolarLines& lines_;
  Several<3> turned_;
  Several<EpipolarLines::terms> depth_;
};

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
