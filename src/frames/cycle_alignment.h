#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "slipstream/frame_set.h"
#include "slipstream/frame_source.h"

namespace slipstream {

/// Indices of a few pixels, spread over an image, used to compare frames. They come in pairs: pixel
/// 2 i + 1 is a few pixels right of and below pixel 2 i.
std::vector<std::size_t> sample_places(Size size);

/// Their grey levels on an 8-bit scale, into `samples`.
void sample(const Frame& frame, const std::vector<std::size_t>& places,
            std::vector<float>& samples);

/// Samples of one cycle of frames by index, in pairs of neighbours: see sample_places.
using CycleSamples = std::vector<std::vector<float>>;

/// Detects patterns that have slipped relative to their indices: frames of one pattern, a cycle
/// apart, differ little; different patterns differ much. Compares each frame with the last one of
/// every index, by the differences of samples where the patterns show.
class SlipWatch {
 public:
  enum class Verdict {
    agrees,    ///< with its index, or inconclusive
    slipping,  ///< agrees with another index, at most half as far away
    slipped,   ///< a full cycle of frames agreed with indices shifted equally
  };
  struct Finding {
    Verdict verdict = Verdict::agrees;
    int places = 0;  ///< shift to add to the indices if slipped
  };

  /// `cycle`: number of repeated patterns; `samples`: per frame.
  SlipWatch(int cycle, std::size_t samples);

  Finding look(int index, const std::vector<float>& samples);

  /// Whether there has been a frame of each index; until then all verdicts are inconclusive.
  [[nodiscard]] bool has_cycle() const { return std::ranges::find(known_, false) == known_.end(); }
  [[nodiscard]] const CycleSamples& cycle() const { return last_; }

  /// Shifts the indices by that many places from now on.
  void move_on(int places);

 private:
  struct Seen {
    int index = 0;
    std::vector<float> samples;
  };

  /// Sums of the differences from the last frame of each index, over the same samples; infinite if
  /// inconclusive.
  void measure_distances(const std::vector<float>& samples);
  void keep(int index, const std::vector<float>& samples);
  /// Accepts the suspected frames with their indices shifted by `places`.
  void settle(int places);
  [[nodiscard]] int moved(int index, int places) const {
    return (index + places % count_ + count_) % count_;
  }

  int count_;
  CycleSamples last_;
  std::vector<bool> known_;
  std::vector<float> distances_;
  std::vector<Seen> suspects_;  ///< one per place of the cycle, the first `suspected_` in use
  int suspected_ = 0, supporting_ = 0, places_ = 0;
};

/// A run of phase-shifted frames in a cycle.
struct CycleRun {
  int first = 0;
  std::vector<double> cosines, sines;  ///< 2/N cos(2 pi n / N) and 2/N sin(2 pi n / N)
};

/// Finds the index shift from one cycle. One sinusoid looks the same from any start and gives no
/// information. With several runs of steps, only the right start fits the frames with one mean and
/// modulation, and has phases that vary more for more periods: compares the residuals for each
/// start.
class CycleAlignment {
 public:
  /// `runs`: all of the cycle, from fewest periods to most; detects nothing without runs.
  explicit CycleAlignment(std::vector<CycleRun> runs);

  /// Shift to add to the indices; 0 if they are right or it is inconclusive.
  [[nodiscard]] int misalignment(const CycleSamples& cycle);

 private:
  struct Explanation {
    double residual = 0;      ///< sum of squares
    bool is_ordered = false;  ///< the phases of bands with more periods vary more
  };

  /// How well the runs explain the cycle if the first frame has index `first`.
  [[nodiscard]] Explanation explain(const CycleSamples& cycle, int first);

  /// A run's sinusoid fitted to the samples of its frames: Liu 2010, Eqs. (1.3)-(1.6).
  struct Fit {
    double frames = 0;                      ///< N
    double mean = 0, cosine = 0, sine = 0;  ///< A, B cos(phi), B sin(phi)
    double residual = 0;                    ///< sum of squares

    [[nodiscard]] double modulation() const { return std::sqrt(cosine * cosine + sine * sine); }
  };
  [[nodiscard]] static Fit fit(const CycleSamples& cycle, std::size_t sample, int first,
                               const CycleRun& run);

  std::vector<CycleRun> runs_;  ///< without runs it detects nothing
  // Reused from cycle to cycle to avoid allocations.
  std::vector<std::array<Fit, 2>> fits_;  ///< of each run, at a sample and its neighbour
  std::vector<double> turns_;             ///< variation of each run's phase
};

/// The index shift of a cycle that ends with a marker, darkest or brightest; nullopt without one.
std::optional<int> marker_misalignment(const CycleSamples& cycle);

}  // namespace slipstream
