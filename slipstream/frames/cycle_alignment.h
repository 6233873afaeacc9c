#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "slipstream/codes/layout.h"

namespace slipstream {

/// The samples of one cycle of frames, in the order of their indices; each frame's in pairs of
/// neighbours, as SampleGrid takes them.
using CycleSamples = std::vector<std::vector<float>>;

/// Tells from one cycle alone by how many places its indices are wrong. Patterns of one sinusoid
/// are a sinusoid wherever one begins to count, so that nothing can be told of them. Several runs
/// of steps fit the frames with one mean and one modulation for all, and the phase of those of more
/// periods varies more from pixel to pixel, only where each begins at its first frame: the residual
/// of that fit is compared for each place. Of a layout that is not made of such runs, one after
/// another, nothing is told.
class CycleAlignment {
 public:
  explicit CycleAlignment(const Layout& layout);

  /// Places to be added to the indices; 0 where they are right or it is not to be told.
  [[nodiscard]] int misalignment(const CycleSamples& cycle);

 private:
  struct Explanation;

  /// How the runs explain the cycle where the first frame has the index `first`.
  [[nodiscard]] Explanation explain(const CycleSamples& cycle, int first);

  /// A run of steps: from few periods to many.
  struct Run {
    int first = 0;
    std::vector<double> cosines, sines;  ///< 2/N cos(2 pi n / N)
  };
  /// A run's sinusoid through the samples of its frames: Liu 2010, Eqs. (1.3)-(1.6).
  struct Fit {
    double frames = 0;                      ///< N
    double mean = 0, cosine = 0, sine = 0;  ///< A, B cos(phi), B sin(phi)
    double residual = 0;                    ///< sum of squares

    [[nodiscard]] double modulation() const;
  };
  [[nodiscard]] static Fit fit(const CycleSamples& cycle, std::size_t sample, int first,
                               const Run& run);

  std::vector<Run> runs_;  ///< empty where nothing is to be told
  // Kept from cycle to cycle, so that nothing is allocated.
  std::vector<std::array<Fit, 2>> fits_;  ///< of each run, at a sample and its neighbour
  std::vector<double> turns_;             ///< how each run's phase varies
};

/// The same for a cycle whose last frame is a marker, darker or brighter than all patterns. None
/// where no frame is one.
std::optional<int> marker_misalignment(const CycleSamples& cycle);

}  // namespace slipstream
