#pragma once

#include <cstddef>
#include <vector>

namespace slipstream {

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

}  // namespace slipstream
