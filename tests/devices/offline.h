// A scan served in a loop, and its expected clouds.
#pragma once

#include <cstring>
#include <vector>

#include "slipstream/camera.h"
#include "slipstream/engine.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "tests/live/virtual_loop.h"

namespace slipstream {

inline constexpr int offline_cycles = 3;
inline constexpr Size offline_size{320, 240};

inline bool same_bits(const Image<float>& one, const Image<float>& other) {
  return one.size() == other.size() &&
         std::memcmp(one.begin(), other.begin(), one.pixel_count() * sizeof(float)) == 0;
}

/// Frames of a moving scene, and the cloud of each window of them.
struct Offline {
  EngineSetup setup{.scanner = example_scanner(offline_size),
                    .sequence = {.strategy = PhaseMeasuring{.steps = 4, .frequency = 1}}};
  std::vector<Frame> loop = frames_of(
      setup.sequence.strategy,
      {.size = offline_size, .motion = Eigen::Vector3d(1, 0, 0.5), .cycles = offline_cycles});
  std::vector<Cloud> clouds;  ///< element n: window that ends with frame n of the loop

  Offline() {
    Engine engine(setup);
    const int count = static_cast<int>(loop.size());
    for (int newest = 0; newest < count; ++newest) {
      Frames<std::uint8_t> window(4);
      for (int age = 0; age < 4; ++age) {
        const int at = (newest - age + count) % count;
        window[static_cast<std::size_t>(at % 4)] =
            std::get<0>(loop[static_cast<std::size_t>(at)].pixels);
      }
      clouds.emplace_back();
      engine.cloud(window, clouds.back());
    }
  }

  [[nodiscard]] bool has(const LiveCloud& live) const {
    const Cloud& cloud = clouds[live.newest.sequence % clouds.size()];
    return same_bits(live.cloud.x, cloud.x) && same_bits(live.cloud.y, cloud.y) &&
           same_bits(live.cloud.z, cloud.z) && same_bits(live.cloud.intensity, cloud.intensity);
  }
};

inline CameraSettings settings_for(const Offline& offline) {
  return {.frame_rate = 100, .packet_size = 8000, .cycle = static_cast<int>(offline.loop.size())};
}

}  // namespace slipstream
