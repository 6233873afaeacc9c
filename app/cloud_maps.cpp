#include "app/cloud_maps.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "app/live_settings.h"
#include "slipstream/frames/window_frames.h"

namespace slipstream::app {

Image<std::uint8_t> CloudMaps::phase(const LiveCloud& cloud) {
  const std::lock_guard lock(mutex_);
  const auto frames = measure(cloud);
  if (!frames) return {};
  const double least = least_modulation(engine_->setup().settings, frames->full_scale());
  Image<std::uint8_t> phase(frames->size());
  std::transform(maps_.wrapped_phase.begin(), maps_.wrapped_phase.end(), maps_.modulation.begin(),
                 phase.begin(), [&](float angle, float modulation) {
                   const float step = angle * (255 / (2 * std::numbers::pi_v<float>));
                   if (!(modulation >= least) || !(step >= 0)) return std::uint8_t{0};
                   return static_cast<std::uint8_t>(1 + std::min(step, 254.0F));
                 });
  return phase;
}

std::optional<Uncertainty> CloudMaps::uncertainty(const LiveCloud& cloud) {
  const std::lock_guard lock(mutex_);
  const auto frames = measure(cloud);
  if (!frames) return std::nullopt;
  return engine_->uncertainty(cloud.cloud, maps_, *frames);
}

std::optional<FrameViews> CloudMaps::measure(const LiveCloud& cloud) {
  if (const std::uint64_t changes = session_.changes; !engine_ || changes != changes_) {
    EngineSetup setup = setup_of(session_);
    motion_ = std::exchange(setup.sequence.motion, 0);
    engine_.emplace(setup);
    changes_ = changes;
  }
  const FrameViews window = views_of(cloud.frames);
  if (window.count() != frame_count(engine_->setup().sequence) + motion_) return std::nullopt;
  const FrameViews cycle = middle_cycle(window, cloud.first_pattern, motion_);
  const FrameViews& frames = engine_->merged(cycle);
  engine_->maps(frames, maps_);
  return frames;
}

}  // namespace slipstream::app
