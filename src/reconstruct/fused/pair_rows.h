#pragma once

#include <complex>

#include "slipstream/frame_set.h"
#include "slipstream/layout.h"

// Stages of matching two cameras, one row of pixels at a time, compiled for each vector target.
namespace slipstream {

/// C + i S of a band without a carrier, Eqs. (1.5), (1.6), grey levels of the frames, which must be
/// quantised.
void phasor_row(const Band& band, const FrameViews& frames, int row, std::complex<float>* to);

/// B and phi, rad, [0, 2 pi), of the phasors of a picture of at least `least_row_width` pixels.
void polar_pixels(const Image<std::complex<float>>& phasors, Image<float>& modulation,
                  Image<float>& phase);

/// Matches of a picture, with `side` further columns before and after each row, in which, as
/// wherever a pixel has no match, the inverse depth is NaN.
struct MatchedRows {
  int window = 0;  ///< half width, pixels; at most `side`
  int side = 0;
  ImageView<const float> inverse_depth;  ///< 1 / Z, 1 / mm
  /// Inverse variance of the inverse depth, up to a factor.
  ImageView<const float> weight;
  ImageView<const float> pixel_step;  ///< change of 1 / Z per pixel of the second camera
};

/// 1 / Z at the centres of planes fitted to each pixel's window: 1 / Z of a plane is linear in the
/// image. Only matches on the same surface count: on a surface that both cameras see, depth changes
/// by less than a pixel of the second camera per pixel. With fewer than 6 of them the match itself.
/// `to`: a row without the further columns.
void plane_row(const MatchedRows& matches, int row, float* to);

}  // namespace slipstream
