#include "slipstream/simulate/virtual_rig.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/simulate/virtual_camera.h"

namespace slipstream {
namespace {

/// One pattern whose shape is the coordinate itself.
PatternSet ramp(Axis axis) {
  return {.count = 1, .axis = axis, .light = {}, .shape = [](int, double y) { return y; }};
}

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

/// The scene one frame later.
void move(Scene& scene) {
  for (Body& body : scene) body.pose.pretranslate(body.motion);
}

}  // namespace

VirtualRig::VirtualRig(Scanner scanner, Scene scene, const Photometry& photometry)
    : scanner_(std::move(scanner)),
      scene_(std::move(scene)),
      photometry_(photometry),
      moving_(std::any_of(scene_.begin(), scene_.end(),
                          [](const Body& body) { return !body.motion.isZero(0); })) {
  if (!photometry.bits) throw Error("a virtual camera has 8 to 16 bits; none are given");
  if (photometry.rays != 1) {
    throw Error(fmt::format("a virtual rig sees 1 ray of a pixel, not {}", photometry.rays));
  }
  look();
}

void VirtualRig::look() {
  columns_ = take_scan(scanner_, scene_, ramp(Axis::x), photometry_);
  rows_ = take_scan(scanner_, scene_, ramp(Axis::y), photometry_);
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

/// Of the projector at what each pixel sees, 0 to 1; NaN in shadow and outside the field.
Image<double> VirtualRig::light_on_scene() const {
  const Image<std::uint8_t>& picture = patterns_[*on_show_];
  Image<double> light(scanner_.camera.size);
  for (int row = 0; row < light.height(); ++row) {
    for (int column = 0; column < light.width(); ++column) {
      const double x = columns_.coordinate(column, row), y = rows_.coordinate(column, row);
      light(column, row) =
          std::isnan(x) ? x : level_at(picture, x * picture.width(), y * picture.height()) / 255;
    }
  }
  return light;
}

Arrival VirtualRig::next(Frame& frame, std::chrono::milliseconds) {
  if (moving_ && taken_ > 0) {
    move(scene_);
    look();
  }
  // With the light in the coordinate's place, the ramp is what the projector shows.
  VirtualScan lit = columns_;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  lit.coordinate = on_show_ ? light_on_scene() : Image<double>(scanner_.camera.size, nan);
  Photometry photometry = photometry_;
  photometry.seed += taken_;
  frame = first_frame(take_again(lit, ramp(Axis::x), photometry));
  frame.stamp = {.sequence = taken_++,
                 .pattern_index = std::nullopt,
                 .device_time = {},
                 .host_time = std::chrono::steady_clock::now()};
  if (on_show_) frame.stamp.pattern_index = static_cast<int>(*on_show_);
  return Arrival::frame;
}

}  // namespace slipstream
