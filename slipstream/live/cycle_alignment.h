#pragma once

#include <optional>
#include <vector>

#include "slipstream/strategy/strategy.h"

namespace slipstream {

/// The samples of one cycle of frames, in the order of their indices; each frame's in pairs of
/// neighbours, as SampleGrid takes them.
using CycleSamples = std::vector<std::vector<float>>;

/// Tells from one cycle alone by how many places its indices are wrong. Patterns of one sinusoid
/// are a sinusoid wherever one begins to count, so that nothing can be told of them. Two sinusoids
/// fit the frames with one mean and one modulation for both, and the phase of the first varies more
/// from pixel to pixel, only where each begins at its first frame: the residual of that fit is
/// compared for each place.
class CycleAlignment {
 public:
  explicit CycleAlignment(const Strategy& strategy);

  /// Places to be added to the indices; 0 where they are right or it is not to be told.
  [[nodiscard]] int misalignment(const CycleSamples& cycle) const;

 private:
  struct Explanation;

  /// How the sinusoids explain the cycle where the first begins at the index `first`.
  [[nodiscard]] Explanation explain(const CycleSamples& cycle, int first) const;

  std::vector<int> steps_;
  std::vector<std::vector<double>> cosines_, sines_;  ///< of each sinusoid: 2/N cos(2 pi n / N)
};

/// The same for a cycle whose last frame is a marker, darker or brighter than all patterns. None
/// where no frame is one.
std::optional<int> marker_misalignment(const CycleSamples& cycle);

}  // namespace slipstream
