#pragma once

#include <optional>
#include <span>
#include <vector>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/unwrapping_chain.h"
#include "slipstream/decode/single_frame_matcher.h"

namespace slipstream {

/// The projector coordinate of one pixel by all unwrappings that ask no neighbour: every one but
/// Unwrapping::vote.
class BandUnwrapper {
 public:
  /// `projector_length`: projector pixels along the axis.
  BandUnwrapper(Layout layout, int projector_length);

  /// What one pixel's frames say.
  struct Reading {
    std::span<const double> phases;  ///< of all bands, rad, [0, 2 pi)
    std::span<const double> modulations;
    /// Of all frames, with a code or single frames; else what there is.
    std::span<const double> intensities;
  };
  struct Coordinate {
    double y = 0;      ///< see BasicMaps
    double doubt = 0;  ///< the most of all steps, see fringe_order_residual; of a code beyond what
                       ///< its stripes leave open; of single frames half of the least misfit over
                       ///< that of the next order
    double contrast = 0;  ///< with Unwrapping::code_alone: see CodeReading
  };
  [[nodiscard]] Coordinate operator()(const Reading& reading) const;

  /// Whether anything could contradict the fringe order.
  [[nodiscard]] bool can_doubt() const;

 private:
  [[nodiscard]] Coordinate by_chain(std::span<const double> phases) const;
  [[nodiscard]] Coordinate likeliest(std::span<const double> phases,
                                     std::span<const double> modulations) const;
  [[nodiscard]] Coordinate by_code(const Reading& reading) const;
  /// That of all bands, at the fringe orders next to y.
  [[nodiscard]] double weighed(std::span<const double> phases, double y) const;

  Layout layout_;
  int projector_length_;
  std::size_t measuring_;
  std::vector<PhaseSum> chain_;
  bool circle_;
  std::vector<double> weights_;
  std::optional<SingleFrameMatcher> single_frames_;
};

}  // namespace slipstream
