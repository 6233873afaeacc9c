// Packets of rays in vectors. Included once for each vector target.
#if defined(SLIPSTREAM_SIMULATE_PACKETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SLIPSTREAM_SIMULATE_PACKETS_INL_H_
#undef SLIPSTREAM_SIMULATE_PACKETS_INL_H_
#else
#define SLIPSTREAM_SIMULATE_PACKETS_INL_H_
#endif

#include "base/vectors-inl.h"
#include "simulate/ray_packet.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

using LaneTag = hn::CappedTag<double, packet_rays>;

/// m v for a matrix of 3 x 3 with columns of `stride` numbers.
HWY_INLINE void turn(const double* m, int stride, const LaneVectors& v, LaneVectors& turned) {
  const double *const a = m, *const b = m + stride, *const c = m + 2 * stride;
  for (int i = 0; i < packet_rays; ++i) {
    const double x = v.x[i], y = v.y[i], z = v.z[i];
    turned.x[i] = a[0] * x + b[0] * y + c[0] * z;
    turned.y[i] = a[1] * x + b[1] * y + c[1] * z;
    turned.z[i] = a[2] * x + b[2] * y + c[2] * z;
  }
}

/// Applies a function of hwy's to each number.
template <class Function>
HWY_INLINE void map_lanes(const Lanes& x, Lanes& result, const Function& function) {
  const LaneTag d;
  for (int i = 0; i < packet_rays; i += static_cast<int>(hn::Lanes(d))) {
    hn::Store(function(d, hn::Load(d, x.data() + i)), d, result.data() + i);
  }
}

HWY_INLINE void sine_lanes(const Lanes& x, Lanes& sine) {
  map_lanes(x, sine, [](LaneTag d, hn::Vec<LaneTag> v) SLIPSTREAM_STEP { return hn::Sin(d, v); });
}

HWY_INLINE void cosine_lanes(const Lanes& x, Lanes& cosine) {
  map_lanes(x, cosine, [](LaneTag d, hn::Vec<LaneTag> v) SLIPSTREAM_STEP { return hn::Cos(d, v); });
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
