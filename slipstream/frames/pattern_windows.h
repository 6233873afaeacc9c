#pragma once

#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/frames/pool.h"

namespace slipstream {

/// Indices of a few pixels, spread over a picture, by which frames are compared. They come in
/// pairs: pixel 2 i + 1 is a few pixels right of and below pixel 2 i.
std::vector<std::size_t> sample_places(Size size);
/// Their grey levels of an 8-bit camera, into `samples`.
void sample(const Frame& frame, const std::vector<std::size_t>& places,
            std::vector<float>& samples);

/// Finds that patterns have slipped against their indices: frames of one pattern, a cycle apart,
/// change little; another pattern is another picture. Compares each frame with the last of every
/// index, by the mean difference of samples where the patterns show.
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
  /// Samples of one cycle of frames by index, each in pairs of neighbours see sample_places.
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
  /// Takes the suspected frames for what they say, moved on by `places`.
  void settle(int places);
  [[nodiscard]] int moved(int index, int places) const {
    return (index + places % count_ + count_) % count_;
  }

  int count_;
  std::vector<std::vector<float>> last_;
  std::vector<bool> known_;
  std::vector<float> distances_;
  std::vector<Seen> suspects_;  ///< as many as the cycle, the first `suspected_` of them used
  int suspected_ = 0;
  int supporting_ = 0;
  int places_ = 0;
};

/// Samples of one cycle of frames by index, each in pairs of neighbours: see sample_places.
using CycleSamples = std::vector<std::vector<float>>;

/// A run of phase-shifted frames in a cycle.
struct CycleRun {
  int first = 0;
  std::vector<double> cosines, sines;  ///< 2/N cos(2 pi n / N), likewise
};

/// Finds from one cycle how many places its indices are off. One sinusoid looks alike from any
/// start, so it says nothing. Several runs of steps fit the frames with one mean and modulation,
/// and phases of more periods vary more from pixel to pixel, only at the right start: the residuals
/// of that fit for each place are compared.
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

/// The same for a cycle that ends with a marker, darkest or brightest; nullopt if no frame is one.
std::optional<int> marker_misalignment(const CycleSamples& cycle);

/// How it is known which pattern a frame shows. Whichever it is, the pictures are watched, and a
/// slipped index is set right: see PatternWindows.
enum class PatternIndexing {
  told,     ///< by the source, FrameStamp::pattern_index; frames that lack it are counted on
  counted,  ///< the frame's sequence modulo the patterns: the projector triggers the camera
  marker,   ///< a dark or bright frame before the first pattern of each cycle of N + 1 frames
};

/// "told", "counted", "marker"; throws Error for any other name.
PatternIndexing pattern_indexing_named(std::string_view name);

/// The frames of a window, of one format, into `views`, whose memory is reused.
void view_window(const std::vector<Pooled<Frame>>& window, FrameViews& views);

/// The same; valid as long as the window's shares are.
FrameViews views_of(const std::vector<Pooled<Frame>>& window);

/// The cycle in the middle of a window of `extra` frames more, in pattern order; `first_pattern`:
/// of the window's first frame.
FrameViews middle_cycle(const FrameViews& window, int first_pattern, int extra);

/// Windows of W successive frames of a cycle of N patterns. Position p shows pattern p modulo N;
/// one without a frame invalidates only the W windows that contain it. A frame may come late until
/// the one W places on has come, so that it keeps no other window waiting.
class RollingWindow {
 public:
  RollingWindow(int frames, int cycle);

  /// False where the position has a frame already, or is too late.
  bool put(std::uint64_t position, Pooled<Frame> frame);

  /// The next window that is whole; false where there is none yet. Windows come in the order of
  /// their newest frames. A window of one cycle is in pattern order, a longer one as frames came.
  bool next(std::vector<Pooled<Frame>>& window);
  /// The pattern of that window's first frame.
  [[nodiscard]] int first_pattern() const { return first_pattern_; }

  /// Forgets all frames and begins again with the next, wherever it is: it is what would have had
  /// the position `first` before. Windows that reach back across here are lost.
  void restart(std::uint64_t first);
  void restart() { restart(newest_ + 1); }

  /// Windows that will never be whole.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  struct Place {
    std::optional<std::uint64_t> position;
    Pooled<Frame> frame;
  };

  [[nodiscard]] Place& at(std::uint64_t position) { return ring_[position % ring_.size()]; }
  [[nodiscard]] bool has(std::uint64_t position) { return at(position).position == position; }
  /// Whether every frame of the window that ends at `next_` is there.
  [[nodiscard]] bool whole();

  std::uint64_t count_, cycle_;
  std::vector<Place> ring_;
  bool begun_ = false;
  std::uint64_t newest_ = 0;  ///< position
  std::uint64_t next_ = 0;    ///< where the next window ends
  std::uint64_t lost_ = 0;
  int first_pattern_ = 0;
};

/// Patterns that are shown over and over.
struct PatternCycle {
  int patterns = 1;              ///< N: of a cycle, for each exposure, without a marker
  int extra = 0;                 ///< frames of a window beyond a cycle
  std::vector<CycleRun> runs{};  ///< see CycleAlignment
};

/// Frames in, windows of the newest N out in pattern order, or of N + K of a cycle with K extra
/// frames, as they came. Indices are as `indexing` says and checked by the pictures: against the
/// cycle before (SlipWatch) and, of several sinusoids, against their own (CycleAlignment). A frame
/// whose picture contradicts its index is in no window; once a cycle of them agrees on the slip, or
/// one cycle shows it at once, indices are corrected and windows made of what is there. One thread
/// uses it.
class PatternWindows {
 public:
  /// `size`: of the frames.
  PatternWindows(PatternCycle cycle, PatternIndexing indexing, Size size);

  /// False where the frame came again, or too late.
  bool put(const Pooled<Frame>& frame);

  /// The next whole window, into `window`; false where there is none yet.
  bool next(std::vector<Pooled<Frame>>& window) { return window_.next(window); }
  /// The pattern of its first frame: see merged_sequence.
  [[nodiscard]] int first_pattern() const { return window_.first_pattern(); }

  /// The source counts its frames from the beginning again.
  void restart();

  /// Windows without all their frames.
  [[nodiscard]] std::uint64_t lost() const { return window_.lost(); }
  [[nodiscard]] std::uint64_t resynchronisations() const { return resynchronisations_; }

 private:
  struct Place {
    int index = 0;               ///< in the cycle; the marker has the last
    std::uint64_t position = 0;  ///< in the row of pattern frames; the marker that of the next
  };

  [[nodiscard]] Place place_of(std::uint64_t sequence) const;
  void follow_source(const FrameStamp& stamp);
  /// Puts it in the window, if it is a pattern.
  bool place(const Pooled<Frame>& frame);
  /// Indices are that many places on, from the oldest of the recent frames.
  void move_on(int places);
  /// By how many places the last cycle shows its indices to be wrong; none where it shows nothing.
  [[nodiscard]] std::optional<int> realignment();

  int patterns_;  ///< N, for each exposure
  int cycle_;     ///< and a marker where there is one
  PatternIndexing indexing_;
  std::vector<std::size_t> sampled_;  ///< see sample_places
  CycleAlignment alignment_;
  SlipWatch watch_;
  RollingWindow window_;
  bool aligned_;
  int told_ = 0;     ///< index minus sequence, as the source has it
  int slipped_ = 0;  ///< what was found to be added to that
  bool begun_ = false;
  std::uint64_t newest_ = 0;           ///< sequence
  std::uint64_t first_ = 0;            ///< sequence of the first frame whose index is counted thus
  std::vector<Pooled<Frame>> recent_;  ///< a cycle of frames, the oldest first
  std::vector<float> samples_;
  std::uint64_t resynchronisations_ = 0;
};

}  // namespace slipstream
