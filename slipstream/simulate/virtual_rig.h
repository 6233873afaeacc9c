#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/frames/frame_source.h"
#include "slipstream/frames/pattern_sink.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/scene.h"
#include "slipstream/simulate/seen_scene.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

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
