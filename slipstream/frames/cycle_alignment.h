#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// A few pixels, spread over the picture, by which frames are compared. They come in pairs: pixel
/// 2 i + 1 is a few pixels right of and below pixel 2 i.
class SampleGrid {
 public:
  static constexpr int pairs = 384;  ///< at most

  explicit SampleGrid(Size size);

  [[nodiscard]] std::size_t count() const { return pixels_.size(); }

  /// Grey levels of an 8-bit camera, into `samples`, which is made as long as count().
  void sample(const Frame& frame, std::vector<float>& samples) const;

 private:
  std::vector<std::size_t> pixels_;  ///< index in the picture
};

/// Tells from the pictures that the patterns have slipped against their indices: of two frames of
/// one pattern, a cycle apart, little has changed; another pattern is another picture. Each frame
/// is compared with the last of every index, by the mean difference of its samples where the
/// patterns show.
class SlipWatch {
 public:
  enum class Verdict {
    agrees,    ///< with its index, or nothing is to be told from it
    slipping,  ///< agrees with another index, at most half as far away
    slipped,   ///< a whole cycle of frames has agreed with indices as many places on
  };
  struct Finding {
    Verdict verdict = Verdict::agrees;
    int places = 0;  ///< to be added to the indices, where slipped
  };

  /// `cycle`: patterns that follow each other and begin again; `samples` of each frame.
  SlipWatch(int cycle, std::size_t samples);

  Finding look(int index, const std::vector<float>& samples);

  /// Whether there has been a frame of each index; until then nothing is told.
  [[nodiscard]] bool has_cycle() const;
  /// The samples of the last frame of each index.
  [[nodiscard]] const std::vector<std::vector<float>>& cycle() const { return last_; }

  /// Indices are that many places on from now.
  void move_on(int places);

 private:
  struct Seen {
    int index = 0;
    std::vector<float> samples;
  };

  /// Mean difference from the last frame of each index; infinite where that tells nothing.
  void measure_distances(const std::vector<float>& samples);
  void keep(int index, const std::vector<float>& samples);
  /// Adds to those that may have slipped.
  void suspect(int index, const std::vector<float>& samples);
  /// Takes the suspected frames for what they say, moved on by `places`.
  void settle(int places);
  [[nodiscard]] int moved(int index, int places) const;

  int count_;
  std::vector<std::vector<float>> last_;
  std::vector<bool> known_;
  std::vector<float> distances_;
  std::vector<Seen> suspects_;  ///< as many as the cycle, the first `suspected_` of them used
  int suspected_ = 0;
  int supporting_ = 0;
  int places_ = 0;
};

/// The samples of one cycle of frames, in the order of their indices; each frame's in pairs of
/// neighbours, as SampleGrid takes them.
using CycleSamples = std::vector<std::vector<float>>;

/// A run of phase-shifted frames in a cycle.
struct CycleRun {
  int first = 0;
  std::vector<double> cosines, sines;  ///< 2/N cos(2 pi n / N), likewise
};

/// Tells from one cycle alone by how many places its indices are wrong. Patterns of one sinusoid
/// are a sinusoid wherever one begins to count, so that nothing can be told of them. Several runs
/// of steps fit the frames with one mean and one modulation for all, and the phase of those of more
/// periods varies more from pixel to pixel, only where each begins at its first frame: the residual
/// of that fit is compared for each place.
class CycleAlignment {
 public:
  /// `runs`: all of the cycle, from few periods to many; with none nothing is told.
  explicit CycleAlignment(std::vector<CycleRun> runs);

  /// Places to be added to the indices; 0 where they are right or it is not to be told.
  [[nodiscard]] int misalignment(const CycleSamples& cycle);

 private:
  struct Explanation;

  /// How the runs explain the cycle where the first frame has the index `first`.
  [[nodiscard]] Explanation explain(const CycleSamples& cycle, int first);

  /// A run's sinusoid through the samples of its frames: Liu 2010, Eqs. (1.3)-(1.6).
  struct Fit {
    double frames = 0;                      ///< N
    double mean = 0, cosine = 0, sine = 0;  ///< A, B cos(phi), B sin(phi)
    double residual = 0;                    ///< sum of squares

    [[nodiscard]] double modulation() const;
  };
  [[nodiscard]] static Fit fit(const CycleSamples& cycle, std::size_t sample, int first,
                               const CycleRun& run);

  std::vector<CycleRun> runs_;  ///< empty where nothing is to be told
  // Kept from cycle to cycle, so that nothing is allocated.
  std::vector<std::array<Fit, 2>> fits_;  ///< of each run, at a sample and its neighbour
  std::vector<double> turns_;             ///< how each run's phase varies
};

/// The same for a cycle whose last frame is a marker, darker or brighter than all patterns. None
/// where no frame is one.
std::optional<int> marker_misalignment(const CycleSamples& cycle);

}  // namespace slipstream
