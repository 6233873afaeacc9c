#pragma once

#include <algorithm>

#include "base/throw_if-inl.h"
#include "simulate/camera_picture.h"
#include "simulate/looped_scene.h"
#include "simulate/projected_light.h"
#include "simulate/seen_scene.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {

/// A simulated projector and camera in front of a scene. The next frame sees the picture that the
/// projector shows, any picture; before the first pattern it is dark. Not thread-safe:
///
///   rig.show(n);
///   rig.next(frame, timeout);  // the scene under pattern n, with new noise
///
/// Without Physics::projector_pixels, light is interpolated between pixel centres, without blur.
/// Bodies move by their `motion` from frame to frame, but not during an exposure.
class VirtualRig : public PatternSink, public FrameSource {
 public:
  /// Throws Error if the scanner or the photometry is invalid, or has no bits.
  VirtualRig(Scanner scanner, Scene scene, const Photometry& photometry = {});

  [[nodiscard]] std::optional<Size> size() const override { return scanner_.projector.size; }
  void load(std::vector<Image<std::uint8_t>> patterns) override;
  void show(std::size_t n) override;
  [[nodiscard]] std::uint64_t shown() const override { return shown_; }

  [[nodiscard]] FrameFormat format() const override;
  [[nodiscard]] bool has_own_pace() const override { return false; }
  void start() override {}
  /// Never waits. Sequence: number of the frame, from 0; pattern index: the pattern shown.
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override { return {.delivered = taken_}; }

  /// Always empty: neither device can fail.
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

/// The picture's grey level between its pixels.
inline double level_at(const Image<std::uint8_t>& picture, double x, double y) {
  x = std::clamp(x, 0.0, picture.width() - 1.0);
  y = std::clamp(y, 0.0, picture.height() - 1.0);
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const int right = std::min(left + 1, picture.width() - 1);
  const int bottom = std::min(top + 1, picture.height() - 1);
  return std::lerp(std::lerp(picture(left, top), picture(right, top), x - left),
                   std::lerp(picture(left, bottom), picture(right, bottom), x - left), y - top);
}

inline VirtualRig::VirtualRig(Scanner scanner, Scene scene, const Photometry& photometry)
    : scanner_(std::move(scanner)),
      scene_(std::move(scene)),
      photometry_(photometry),
      seen_(scanner_.camera.size) {
  throw_if(!photometry.bits, "a virtual camera has 8 to 16 bits; none are given");
  require_valid(scanner_);
  require_valid(photometry_);
  seen_ = look(scanner_, scene_, photometry_, 0);
}

inline void VirtualRig::load(std::vector<Image<std::uint8_t>> patterns) {
  require_patterns(patterns, size(), "the virtual projector");
  patterns_ = std::move(patterns);
  on_show_.reset();
}

inline void VirtualRig::show(std::size_t n) {
  static_cast<void>(patterns_.at(n));
  on_show_ = n;
  ++shown_;
}

inline FrameFormat VirtualRig::format() const {
  return {scanner_.camera.size, *photometry_.bits};
}

inline Arrival VirtualRig::next(Frame& frame, std::chrono::milliseconds) {
  if (is_moving(scene_) && taken_ > 0) {
    seen_ = look(scanner_, scene_, photometry_, static_cast<double>(taken_));
  }
  ProjectedLight light = [&](const LitSample& sample) {
    if (!on_show_) return 0.0;
    const double level = level_at(patterns_[*on_show_], sample.pixel.x(), sample.pixel.y());
    return responded(level, photometry_);
  };
  if (on_show_ && photometry_.physics.projector_pixels) {
    light = light_of_picture(patterns_[*on_show_], photometry_);
  }
  std::vector<Image<double>> exposures;
  const int number = static_cast<int>(taken_);
  exposures.push_back(exposed(seen_, photometry_, number, 1, light));
  frame = first_frame(camera_pictures(std::move(exposures), number, photometry_));
  frame.stamp = {.sequence = taken_++,
                 .pattern_index = std::nullopt,
                 .host_time = std::chrono::steady_clock::now()};
  if (on_show_) frame.stamp.pattern_index = static_cast<int>(*on_show_);
  return Arrival::frame;
}

}  // namespace slipstream
