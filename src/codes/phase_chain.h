#pragma once

#include <vector>

#include "slipstream/unwrapping.h"

// Chains of phases that are unwrapped one by another, from few periods to many, and how much noise
// their steps bear.
namespace slipstream {

/// Rounding of numbers of periods.
inline constexpr double chain_rounding = 1e-9;

bool is_whole(double ratio);

/// The sum of one band only.
PhaseSum band_alone(const Layout& layout, std::size_t band);

/// Variance of the band's phase for B = 1 at a share of 1 and frame noise of variance 1.
double phase_noise(const Band& band);

/// Squared distance, in standard deviations, that noise must move C + i S to turn it by `angle`.
double turn(double angle, double phase_noise);

/// The bands from coarse to fine.
std::vector<PhaseSum> chain_of_bands(const Layout& layout);

/// The surest chain of sums and differences of the bands; an empty one if impossible. A cyclic
/// chain is unaffected by the field's ends, so it may have a somewhat lower margin.
std::vector<PhaseSum> chain_of_beats(const Layout& layout);

/// A wrong order for each step of a chain.
std::vector<WrongOrder> wrong_steps(const Layout& layout, const std::vector<PhaseSum>& chain);

/// The least margin; infinite if there is none.
double nearest_of(const std::vector<WrongOrder>& wrong);

}  // namespace slipstream
