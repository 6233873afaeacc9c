#pragma once

#include <atomic>
#include <chrono>
#include <string>

#include "slipstream/frames/frame_source.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/scene.h"
#include "slipstream/simulate/seen_scene.h"
#include "slipstream/simulate/virtual_scanner.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// The frames of a camera while the patterns are shown `cycles` times, ready to be repeated: bodies
/// move from frame to frame, to and fro through where they stand at time 0; round and round where
/// they only turn and the frames last a whole turn, to half a cycle. Each frame has noise of its
/// own. Sets sequence and pattern index of the stamps. Throws Error for less than one cycle or a
/// photometry without bits, and as take_scan.
std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles);

/// What a camera sees of a sheet that is held still for `still_cycles` in each pose and moved on
/// within one, the last pose followed by the first, while a projector repeats the patterns of all
/// sets. Of the last pose one cycle is enough. Each frame of a pose is rendered once; `rendered` is
/// called after each pose. Throws Error for less than one pose or cycle, and as virtual_frames.
Reel moved_board(const VirtualWorld& world, Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                 const std::vector<PatternSet>& sets, int still_cycles,
                 const std::function<void()>& rendered);

/// The first frame of a set; black where the set is unquantised.
Frame first_frame(const FrameSet& exposed);

/// Repeats frames from memory without end, and counts them as a real camera does.
class VirtualCamera : public FrameSource {
 public:
  /// Frames that a camera of its own pace keeps until they are fetched; then it loses the oldest.
  static constexpr int waiting_frames = 8;

  /// `loop`: frames of one format, which keep the pattern index of their stamps. `rate`: Hz;
  /// without one frames come as fast as they are asked for. Throws Error where there are no frames,
  /// their formats differ or the rate is not positive.
  explicit VirtualCamera(std::vector<Frame> loop, std::optional<double> rate = std::nullopt);

  [[nodiscard]] FrameFormat format() const override { return loop_.front().format(); }
  [[nodiscard]] bool has_own_pace() const override { return rate_.has_value(); }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override {
    return {.delivered = delivered_, .lost = lost_};
  }
  [[nodiscard]] std::string state() const override { return {}; }

 private:
  using Clock = std::chrono::steady_clock;

  /// When frame `sequence_` is whole; waits for it. None where that is past `end`.
  std::optional<Clock::time_point> wait_until(Clock::time_point end);
  [[nodiscard]] Clock::time_point due(std::uint64_t sequence) const;

  std::vector<Frame> loop_;
  std::optional<double> rate_;
  Clock::time_point start_;
  std::uint64_t sequence_ = 0;
  std::atomic<std::uint64_t> delivered_ = 0, lost_ = 0;
};

/// A projector and a camera before a scene, in this machine: a world that answers patterns with
/// frames. What the projector shows, any pictures, is what the next frame sees; before the first
/// pattern it is dark. One thread uses both:
///
///   rig.show(n);
///   rig.next(frame, timeout);  // the scene under pattern n, with noise of its own
///
/// Unless physics say that the projector has pixels, light goes evenly from the centre of one to
/// the next, without blur. Bodies go on by their `motion` from frame to frame, still in each
/// exposure.
class VirtualRig : public PatternSink, public FrameSource {
 public:
  /// Throws Error where the scanner or the photometry is not valid or says no bits.
  VirtualRig(Scanner scanner, Scene scene, const Photometry& photometry = {});

  [[nodiscard]] std::optional<Size> size() const override { return scanner_.projector.size; }
  void load(std::vector<Image<std::uint8_t>> patterns) override;
  void show(std::size_t n) override;
  [[nodiscard]] std::uint64_t shown() const override { return shown_; }

  [[nodiscard]] FrameFormat format() const override;
  [[nodiscard]] bool has_own_pace() const override { return false; }
  void start() override {}
  /// Never waits. Sequence: of the frames taken, from 0; pattern index: the one on show.
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override { return {.delivered = taken_}; }

  /// Of both: nothing is ever amiss.
  [[nodiscard]] std::string state() const override { return {}; }

 private:
  Scanner scanner_;
  Scene scene_;
  Photometry photometry_;
  SeenScene seen_;
  std::vector<Image<std::uint8_t>> patterns_;
  std::optional<std::size_t> on_show_;
  std::uint64_t shown_ = 0, taken_ = 0;
};

}  // namespace slipstream
