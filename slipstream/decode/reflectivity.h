#pragma once

#include "slipstream/codes/pattern_set.h"

namespace slipstream {

/// Reflectivity alpha of a pixel from the modulation B^c (grey levels) of N-step PMP: Liu 2010, Eq.
/// (3.6). Of a sinusoid with a share c_1 of the modulation, Eq. (3.59), give c_1.
double reflectivity(double modulation, double alpha_p, double share = 1);

/// Ambient light beta (grey levels; negative where the camera takes an offset off) from the mean
/// A^c of N-step PMP and the reflectivity: Eq. (3.5).
double ambient_light(double mean, double alpha, const PatternLight& light);

/// The beta_p above which no frame underflows at that reflectivity: Eq. (3.7); 0 where the ambient
/// light is not negative.
double least_beta_p(double alpha, double ambient);

/// The reflectivity above which no frame underflows at that beta_p: Eq. (3.9); 0 where the ambient
/// light is not negative, infinite where no reflectivity is enough.
double least_reliable_reflectivity(double beta_p, double ambient);

/// The estimate of alpha that stays stable whatever c_1: Eq. (3.97), c_1 alpha_1 + c_2 alpha_2, of
/// the estimates by either modulation.
double weighted_reflectivity(double alpha_1, double alpha_2, double c1);

}  // namespace slipstream
