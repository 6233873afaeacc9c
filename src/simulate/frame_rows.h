#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "simulate/seen_scene.h"

namespace slipstream {

// Rows of frames in vectors.

/// Fills `values` with gaussian() of consecutive pixels, from `first` on.
void set_gaussians(std::uint64_t seed, std::uint64_t frame, std::uint64_t first,
                   std::span<double> values);

/// Noise of a pixel: its light times `sensitivity` plus `offset`, and Gaussian noise of variance
/// `constant` plus `level` times the light.
struct RowNoise {
  std::span<const double> sensitivity, offset, gaussians;
  double constant = 0, level = 0;
  double of_row = 0;  ///< the row's own offset, grey levels
};

void add_row_noise(const RowNoise& noise, std::span<double> light);

/// to += weight from.
void add_scaled(std::span<const double> from, double weight, double* to);

/// The weighted mean of a row and those beside it: `before` and `after` are those at distance 1, 2
/// and so on. Weights are those of a Gaussian of the pixel's `deviation`, to four deviations.
void blur_row(const double* row, std::span<const double* const> before,
              std::span<const double* const> after, std::span<const double> deviation,
              double* blurred);

/// A pattern across the projector under `steps` blurs, each a profile of `size` samples.
struct BlurredProfiles {
  std::vector<double> samples{};
  int size = 0, steps = 0;
  double places = 1;     ///< samples of a projector pixel
  double blur_step = 1;  ///< pixels, between profiles
  bool along_columns = true;
};

/// The light of positions in the projector's picture. Interpolates linearly in place and in the
/// square of the blur, by which a Gaussian reduces modulation.
void light_of(const BlurredProfiles& profiles, std::span<const LitSample> samples, double* light);

}  // namespace slipstream
