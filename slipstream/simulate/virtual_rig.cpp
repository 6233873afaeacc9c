#include "slipstream/simulate/virtual_rig.h"

#include <algorithm>
#include <utility>

#include "slipstream/base/error.h"
#include "slipstream/simulate/projected_light.h"
#include "slipstream/simulate/sensor.h"
#include "slipstream/simulate/virtual_camera.h"

namespace slipstream {
namespace {

/// The picture's grey level at a place between its pixels.
double level_at(const Image<std::uint8_t>& picture, double x, double y) {
  x = std::clamp(x, 0.0, picture.width() - 1.0);
  y = std::clamp(y, 0.0, picture.height() - 1.0);
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const int right = std::min(left + 1, picture.width() - 1);
  const int bottom = std::min(top + 1, picture.height() - 1);
  return std::lerp(std::lerp(picture(left, top), picture(right, top), x - left),
                   std::lerp(picture(left, bottom), picture(right, bottom), x - left), y - top);
}

}  // namespace

VirtualRig::VirtualRig(Scanner scanner, Scene scene, const Photometry& photometry)
    : scanner_(std::move(scanner)),
      scene_(std::move(scene)),
      photometry_(photometry),
      seen_(scanner_.camera.size) {
  if (!photometry.bits) throw Error("a virtual camera has 8 to 16 bits; none are given");
  require_valid(scanner_);
  require_valid(photometry_);
  seen_ = look(scanner_, scene_, photometry_, 0);
}

void VirtualRig::load(std::vector<Image<std::uint8_t>> patterns) {
  require_patterns(patterns, size(), "the virtual projector");
  patterns_ = std::move(patterns);
  on_show_.reset();
}

void VirtualRig::show(std::size_t n) {
  static_cast<void>(patterns_.at(n));
  on_show_ = n;
  ++shown_;
}

FrameFormat VirtualRig::format() const {
  return {scanner_.camera.size, *photometry_.bits};
}

Arrival VirtualRig::next(Frame& frame, std::chrono::milliseconds) {
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
  add_noise(exposures.back(), number, photometry_);
  frame = first_frame(digitised(std::move(exposures), photometry_.bits));
  frame.stamp = {.sequence = taken_++,
                 .pattern_index = std::nullopt,
                 .device_time = {},
                 .host_time = std::chrono::steady_clock::now()};
  if (on_show_) frame.stamp.pattern_index = static_cast<int>(*on_show_);
  return Arrival::frame;
}

}  // namespace slipstream
