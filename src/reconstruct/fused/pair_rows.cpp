// Phases of a row of frames, and planes through the matches of two cameras.
#include "reconstruct/fused/pair_rows.h"

#include <algorithm>
#include <type_traits>

#include "base/numbers.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruct/fused/pair_rows.cpp"
#include <hwy/foreach_target.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

template <class Pixel>
void sum_row(const Band& band, const Frames<Pixel>& frames, int row, std::complex<float>* to) {
  const FloatTag d;
  auto* const interleaved = reinterpret_cast<float*>(to);

  for_each_vector(frames.front().width(), [&](std::size_t i) SLIPSTREAM_STEP {
    Floats C = hn::Zero(d), S = C;
    for (std::size_t n = 0; n < band.cosine.size(); ++n) {
      const auto cosine = static_cast<float>(band.cosine[n]);
      const auto sine = static_cast<float>(band.sine[n]);
      if (cosine == 0 && sine == 0) continue;

      const Floats level = hn::ConvertTo(d, load_pixels(frames[n].row(row) + i));
      C = hn::MulAdd(level, hn::Set(d, cosine), C);
      S = hn::MulAdd(level, hn::Set(d, sine), S);
    }

    hn::StoreInterleaved2(C, S, d, interleaved + 2 * i);
  });
}

void sum_row_of(const Band& band, const FrameViews& frames, int row, std::complex<float>* to) {
  frames.visit([&]<class Pixel>(const Frames<Pixel>& all) {
    if constexpr (!std::is_same_v<Pixel, double>) sum_row(band, all, row, to);
  });
}

void polar_form(const Image<std::complex<float>>& phasors, Image<float>& modulation,
                Image<float>& phase) {
  const FloatTag d;
  const auto* const interleaved = reinterpret_cast<const float*>(phasors.begin());

  for_each_vector(static_cast<int>(phasors.pixel_count()), [&](std::size_t i) SLIPSTREAM_STEP {
    Several<1> C, S;
    hn::LoadInterleaved2(d, interleaved + 2 * i, C[0], S[0]);
    const Floats square = hn::MulAdd(C[0], C[0], hn::Mul(S[0], S[0]));
    hn::StoreU(hn::Sqrt(square), d, modulation.begin() + i);

    // A whole turn is none.
    const Floats turn = angles_in_turns<1>(S, C)[0];
    const auto is_whole = hn::Ge(turn, hn::Set(d, 1.0F));
    const Floats phi = hn::Mul(turn, hn::Set(d, static_cast<float>(two_pi)));
    hn::StoreU(hn::IfThenZeroElse(is_whole, phi), d, phase.begin() + i);
  });
}

/// Sums over a window of the matches on the centre's surface: of the weights w and of their
/// products with the place (x, y) beside the centre and with r, the inverse depth less the
/// centre's.
struct PlaneSums {
  Floats w, wx, wy, wxx, wxy, wyy;
  Floats r, rx, ry;
  Floats count;
};

HWY_INLINE PlaneSums window_sums(const MatchedRows& matches, int row, std::size_t i,
                                 Floats centre) {
  const FloatTag d;
  const Floats zero = hn::Zero(d), one = hn::Set(d, 1);

  // The window's first column, and the largest change of 1 / Z per pixel on one surface.
  const auto first = static_cast<std::size_t>(matches.side - matches.window) + i;
  const Floats step = hn::LoadU(d, matches.pixel_step.row(row) + matches.side + i);

  PlaneSums all{zero, zero, zero, zero, zero, zero, zero, zero, zero, zero};
  const int last = matches.inverse_depth.height() - 1;
  for (int y = std::max(0, row - matches.window); y <= std::min(last, row + matches.window); ++y) {
    const float* const depth = matches.inverse_depth.row(y) + first;
    const float* const weights = matches.weight.row(y) + first;
    const int across = std::abs(y - row);

    // Sums of this row, to be multiplied by its place in the window once.
    Floats w = zero, wx = zero, wxx = zero, r = zero, rx = zero;
    for (int k = 0; k <= 2 * matches.window; ++k) {
      const int x = k - matches.window;

      // Only matches on the centre's surface: 1 / Z may differ by a step, and by another for each
      // row and column between them.
      const Floats rest = hn::Sub(hn::LoadU(d, depth + k), centre);
      const Floats limit = hn::Mul(step, hn::Set(d, static_cast<float>(1 + std::abs(x) + across)));
      const auto same = hn::Le(hn::Abs(rest), limit);
      const Floats weight = hn::IfThenElseZero(same, hn::LoadU(d, weights + k));
      const Floats part = hn::IfThenElseZero(same, hn::Mul(weight, rest));
      const Floats place = hn::Set(d, static_cast<float>(x));
      const Floats moment = hn::Mul(weight, place);
      w = hn::Add(w, weight);
      wx = hn::Add(wx, moment);
      wxx = hn::MulAdd(moment, place, wxx);
      r = hn::Add(r, part);
      rx = hn::MulAdd(part, place, rx);
      all.count = hn::Add(all.count, hn::IfThenElseZero(same, one));
    }

    const Floats place = hn::Set(d, static_cast<float>(y - row));
    all.w = hn::Add(all.w, w);
    all.wx = hn::Add(all.wx, wx);
    all.wxx = hn::Add(all.wxx, wxx);
    all.r = hn::Add(all.r, r);
    all.rx = hn::Add(all.rx, rx);
    all.wy = hn::MulAdd(w, place, all.wy);
    all.wxy = hn::MulAdd(wx, place, all.wxy);
    all.wyy = hn::MulAdd(hn::Mul(w, place), place, all.wyy);
    all.ry = hn::MulAdd(r, place, all.ry);
  }

  return all;
}

/// The plane's value at the centre, less the centre's own: the first unknown of the normal
/// equations, by determinants.
HWY_INLINE Floats height_at_centre(const PlaneSums& s) {
  const auto minor = [](Floats a, Floats b, Floats c, Floats e)
                         SLIPSTREAM_STEP { return hn::NegMulAdd(b, c, hn::Mul(a, e)); };
  const Floats both = minor(s.wxx, s.wxy, s.wxy, s.wyy);

  // The determinant of the matrix with this first column; by Cramer's rule, the quotient of two
  // such determinants is the first unknown.
  const auto determinant = [&](Floats top, Floats left, Floats below) SLIPSTREAM_STEP {
    const Floats second = minor(left, s.wxy, below, s.wyy);
    const Floats third = minor(left, s.wxx, below, s.wxy);
    return hn::MulAdd(s.wy, third, hn::NegMulAdd(s.wx, second, hn::Mul(top, both)));
  };

  return hn::Div(determinant(s.r, s.rx, s.ry), determinant(s.w, s.wx, s.wy));
}

void fit_row(const MatchedRows& matches, int row, float* to) {
  const FloatTag d;
  const float* const centres = matches.inverse_depth.row(row) + matches.side;
  for_each_vector(matches.inverse_depth.width() - 2 * matches.side,
                  [&](std::size_t i) SLIPSTREAM_STEP {
                    const Floats centre = hn::LoadU(d, centres + i);
                    if (hn::AllTrue(d, hn::IsNaN(centre))) return hn::StoreU(centre, d, to + i);

                    // The plane replaces the match if it rests on enough matches and lies in front
                    // of the camera.
                    const PlaneSums sums = window_sums(matches, row, i, centre);
                    const Floats fitted = hn::Add(centre, height_at_centre(sums));
                    const auto enough = hn::Ge(sums.count, hn::Set(d, 6));
                    const auto good = hn::And(enough, hn::Gt(fitted, hn::Zero(d)));
                    hn::StoreU(hn::IfThenElse(good, fitted, centre), d, to + i);
                  });
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(sum_row_of);
HWY_EXPORT(polar_form);
HWY_EXPORT(fit_row);

void phasor_row(const Band& band, const FrameViews& frames, int row, std::complex<float>* to) {
  HWY_DYNAMIC_DISPATCH(sum_row_of)(band, frames, row, to);
}

void polar_pixels(const Image<std::complex<float>>& phasors, Image<float>& modulation,
                  Image<float>& phase) {
  HWY_DYNAMIC_DISPATCH(polar_form)(phasors, modulation, phase);
}

void plane_row(const MatchedRows& matches, int row, float* to) {
  HWY_DYNAMIC_DISPATCH(fit_row)(matches, row, to);
}

}  // namespace slipstream
#endif
