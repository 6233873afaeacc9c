#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/frames/pattern_sink.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/scene.h"
#include "slipstream/simulate/seen_scene.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// What a camera sees while the patterns are shown `cycles` times over, one after the other, ready
/// to be shown again from the start: the bodies move frame by frame, through the place where they
/// stand at time 0, to and fro; round and round where they only turn and the frames are those of a
/// whole turn, but for half a cycle. Each frame has noise of its own. Sequence and pattern
/// index of the stamps are set. Throws Error where cycles are not 1 or more, the photometry says no
/// bits, or as take_scan.
std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles);

/// The first frame of a set, as a camera gives it; black where the set is unquantised.
Frame first_frame(const FrameSet& exposed);

/// A camera that gives frames from memory over and over, without end, and counts them as a real
/// one does.
class VirtualCamera : public FrameSource {
 public:
  /// Frames that wait in a camera of its own pace until they are fetched; then the oldest is lost.
  static constexpr int waiting_frames = 8;

  /// `loop`: of one format, each with the pattern index that its stamp says. `rate`: Hz; without
  /// one frames come as fast as they are asked for. Throws Error where there are no frames, their
  /// formats differ or the rate is not positive.
  explicit VirtualCamera(std::vector<Frame> loop, std::optional<double> rate = std::nullopt);

  [[nodiscard]] FrameFormat format() const override { return loop_.front().format(); }
  [[nodiscard]] bool has_own_pace() const override { return rate_.has_value(); }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override;
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
  std::atomic<std::uint64_t> delivered_ = 0;
  std::atomic<std::uint64_t> lost_ = 0;
};

/// A projector and a camera before a scene, in this machine: a world that answers patterns with
/// frames. What the projector shows, any pictures, is what the next frame sees; before the first
/// pattern it is dark. One thread uses both:
///
///   rig.show(n);
///   rig.next(frame, timeout);  // the scene under pattern n, with noise of its own
///
/// Where physics do not say that the projector has pixels, the light goes from the centre of one to
/// the next evenly, whatever its blur.
/// Bodies go on by their `motion` from each frame to the next, still while a frame is exposed.
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
