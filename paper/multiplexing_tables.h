#pragma once

#include <cstdint>
#include <vector>

#include "paper/reproduction.h"
#include "slipstream/frame_set.h"
#include "slipstream/image.h"
#include "slipstream/pattern_set.h"

namespace slipstream {

/// Properties of every pixel in the simulations of Chapter 3.
struct NoisyPixels {
  double alpha = 0.5;
  double beta = -7;              ///< ambient light, grey levels
  double noise_variance = 1.55;  ///< sigma_w^2, grey levels^2
  double ambient_variance = 0;   ///< of beta over the pixels, grey levels^2
};

/// Frames of the patterns at projector coordinate `y`: Liu 2010, Eqs. (3.2) and (3.10), Gaussian
/// noise, not quantised.
FrameSet noisy_frames(const PatternSet& patterns, const Image<double>& y, const NoisyPixels& pixels,
                      std::uint64_t seed);

/// One cell of Tables 3.1, 3.2, 3.3 of Liu 2010: share of pixels unwrapped correctly, %.
struct UnwrappingCell {
  int steps = 3;  ///< N
  double alpha_p = 200;
  double high = 3;  ///< f_h
  double c1 = 0.5;
  double published = 0;   ///< as printed, %
  double recomputed = 0;  ///< by the published rule, %
  double improved = 0;    ///< by the default rule, %
  /// Pixels that the published rule unwraps correctly and the default rule does not.
  std::size_t worse = 0;
};

/// Simulation of the cells: beta_p = 255 - alpha_p, frames not quantised.
struct UnwrappingTrial {
  enum class Surface { smooth, stepped };
  Surface surface = Surface::smooth;  ///< `stepped` has depth edges
  NoisyPixels pixels{};
  Size size{640, 480};
  std::uint64_t seed = 1;
};

/// The nine cells of Table 3.1, 3.2 or 3.3, row by row, as printed and recomputed. `steps`: 3, 4 or
/// 5. Throws Error for other steps.
std::vector<UnwrappingCell> unwrapping_table(int steps, const UnwrappingTrial& trial = {});

/// Computes the percentages of one cell for pixels at projector coordinate `y`; decodes with a beta
/// of -7.
void recompute(UnwrappingCell& cell, const Image<double>& y, const NoisyPixels& pixels,
               std::uint64_t seed);

/// Projector coordinate of a smooth surface: from one end of the field to the other down the rows.
Image<double> smooth_coordinate(Size size);

/// Projector coordinate of a slope behind 24 discs, blocks and strips. Their offsets differ, from a
/// small part of a period to many periods, some close to whole ones.
Image<double> stepped_coordinate(Size size);

/// One cell of Tables 3.5 and 3.7 or of Section 3.3 of Liu 2010: variance of y with unit-frequency
/// PMP divided by the variance with PCMP of the same N, over the pixels that PCMP unwraps
/// correctly.
struct VarianceRatioCell {
  int steps = 4;
  double high = 4;
  double c1 = 0.5;
  double published = 0;  ///< the dissertation's measurement, as printed
  double predicted = 0;  ///< c_1^2 f_h^2, Eqs. (3.40) and (3.63)
  double measured = 0;   ///< on a virtual scan of a board
  double of_foam = 0;    ///< the same with the gamma and translucency of VarianceRatioTrial
};

/// Setup of the measurement: a board in view of the example scanner, alpha_p = 200, beta_p = 55,
/// beta = -7, sigma_w^2 = 1.55, 8 bits.
struct VarianceRatioTrial {
  Size camera{640, 480};
  std::uint64_t seed = 1;
  /// Fits the print best. The second harmonic in (3.79) minus (3.20), 1.4 %, fits a gamma of
  /// 1.04 for patterns of the full range, of 1.08 for these.
  double gamma = 1.04;
  double translucency = 4.5;  ///< mm in a white foam board, see Physics
};

/// The nine cells of Table 3.5 (`steps` 4) or 3.7 (5), row by row, or the one of Section 3.3 (3).
/// Throws Error for other steps.
std::vector<VarianceRatioCell> variance_ratio_table(int steps,
                                                    const VarianceRatioTrial& trial = {});

/// Liu 2010, Tables 3.1 to 3.3 by the published and by the default rule, Tables 3.5 and 3.7 on the
/// virtual scanner.
std::vector<Reproducible> multiplexing_table_reproducibles();

}  // namespace slipstream
