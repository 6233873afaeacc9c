#include "slipstream/check/fit.h"

#include <algorithm>
#include <cmath>

namespace slipstream {
namespace {

// Right scans: agreement above 0.69, and 0.81 on a real skull; offsets below 0.05. A wrong number
// of periods or order of frames leaves less than 0.6 or more than 0.1 nearly always.
constexpr double least_agreement = 0.6, most_offset = 0.1;
// Below this noise leaves nothing to judge by.
constexpr double least_noise = 0.3;
// Right scans leave 0.014, real ones of twelve steps 0.07; two frames in each other's place 0.15 to
// 0.4.
constexpr double most_residual = 0.1;
// Things that move between frames leave up to 0.15.
constexpr double most_residual_moving = 0.25;
// Right scans 0.31, a real skull 0.43; frames of two bands mixed up 0.7.
constexpr double most_ratio_spread = 0.6;
constexpr double most_seams = 0.015;
// Surfaces seen at a slant change the slope, by 0.58 to 1.8 in the median of right scans.
constexpr double least_slope = 0.35, most_slope = 2.8;
constexpr double most_outside = 0.25;
constexpr double most_out_of_range = 0.6;

/// Of the slopes that noise leaves possible.
double nearest_to_one(const GeometryEvidence& geometry) {
  return std::clamp(1.0, geometry.slope - geometry.slope_doubt,
                    geometry.slope + geometry.slope_doubt);
}

bool agrees(const BandRelation& relation) {
  return relation.noise < least_noise ||
         (relation.agreement >= least_agreement && std::abs(relation.offset) <= most_offset);
}

}  // namespace

bool Fit::bands_alike() const {
  return frames.ratio_spread <= most_ratio_spread;
}

bool Fit::bands_agree() const {
  return bands_alike() && std::all_of(frames.relations.begin(), frames.relations.end(), agrees);
}

bool Fit::patterns_made() const {
  return frames.residual <= (moving ? most_residual_moving : most_residual);
}

bool Fit::no_seam() const {
  return frames.seams <= most_seams;
}

bool Fit::geometry_fits() const {
  if (!geometry) return true;
  return geometry->slope + geometry->slope_doubt >= least_slope &&
         geometry->slope - geometry->slope_doubt <= most_slope &&
         geometry->without_point + geometry->outside <= most_outside;
}

bool Fit::depths_fit() const {
  return !geometry || geometry->out_of_range <= most_out_of_range;
}

double Fit::misfit() const {
  double sum = frames.residual / most_residual + frames.seams / most_seams +
               frames.ratio_spread / most_ratio_spread;
  for (const BandRelation& relation : frames.relations) {
    sum += std::max(0.0, 1 - relation.agreement) / (1 - least_agreement) +
           std::abs(relation.offset) / most_offset;
  }
  if (geometry) {
    sum += (geometry->without_point + geometry->outside) / most_outside +
           geometry->out_of_range / most_out_of_range +
           std::abs(std::log(std::max(1e-3, nearest_to_one(*geometry))));
  }
  return sum;
}

}  // namespace slipstream
