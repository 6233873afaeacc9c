#pragma once

#include <span>
#include <vector>

#include "slipstream/pattern/layout.h"
#include "slipstream/pattern/unwrapping_chain.h"

namespace slipstream {

/// The projector coordinate of one pixel by all unwrappings that ask no neighbour: every one but
/// Unwrapping::vote.
class BandUnwrapper {
 public:
  /// `projector_length`: projector pixels along the axis.
  BandUnwrapper(Layout layout, int projector_length);

  struct Coordinate {
    double y = 0;      ///< see BasicMaps
    double doubt = 0;  ///< the most of all steps, see fringe_order_residual; of a code beyond what
                       ///< its stripes leave open
  };
  /// `phases` (rad, [0, 2 pi)) and `modulations` of all bands; `stripe` by the code, where there is
  /// one.
  [[nodiscard]] Coordinate operator()(std::span<const double> phases,
                                      std::span<const double> modulations, int stripe) const;

  /// Whether anything could contradict the fringe order.
  [[nodiscard]] bool can_doubt() const;

 private:
  [[nodiscard]] Coordinate by_chain(std::span<const double> phases) const;
  [[nodiscard]] Coordinate likeliest(std::span<const double> phases,
                                     std::span<const double> modulations) const;
  [[nodiscard]] Coordinate by_code(double phi, int stripe) const;
  /// That of all bands, at the fringe orders next to y.
  [[nodiscard]] double weighed(std::span<const double> phases, double y) const;

  Layout layout_;
  int projector_length_;
  std::size_t measuring_;
  std::vector<PhaseSum> chain_;
  bool circle_;
  std::vector<double> weights_;
};

}  // namespace slipstream
