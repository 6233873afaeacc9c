// Several exposures live: each window is merged as a scan of its frames would be.
#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/codes/registry.h"
#include "slipstream/frames/merged_exposures.h"
#include "slipstream/frames/window_frames.h"
#include "slipstream/live/exposure_series.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/virtual_camera.h"

namespace slipstream::exposures_test {

TEST(Exposures, LiveCloudsAreThoseOfAFolder) {
  const Scanner scanner = example_scanner({96, 72});
  const Sequence sequence{.strategy = DualFrequency{}, .exposures = {0.5, 2, 8}};
  const auto loop = virtual_frames(scanner, scene_named("contrast", scanner), pattern_set(sequence),
                                   {.ambient = 5, .noise_variance = 1}, 1);
  Engine of_folder(scanner, merged_sequence(sequence));
  int equal = 0, other = 0;
  LiveSettings settings{.most_frames = 60};
  settings.on_cloud = [&](const Pooled<LiveCloud>& live) {
    const FrameSet merged = merged_exposures(views_of(live->frames), sequence.exposures);
    Cloud cloud;
    of_folder.cloud(merged, cloud);
    const bool same =
        std::equal(cloud.intensity.begin(), cloud.intensity.end(), live->cloud.intensity.begin()) &&
        std::memcmp(cloud.z.begin(), live->cloud.z.begin(),
                    cloud.z.pixel_count() * sizeof(float)) == 0;
    ++(same && point_count(cloud) > 0 ? equal : other);
  };
  LivePipeline pipeline(std::make_unique<VirtualCamera>(loop), {scanner, sequence}, settings);
  pipeline.start();
  while (pipeline.running()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  pipeline.stop();
  EXPECT_EQ(pipeline.failure(), nullptr);
  EXPECT_EQ(equal, 60 - static_cast<int>(loop.size()) + 1);
  EXPECT_EQ(other, 0);
}

TEST(Exposures, OneWindowOfASourceIsInPatternOrder) {
  const Scanner scanner = example_scanner({64, 48});
  const Sequence sequence{.strategy = DualFrequency{}};
  const auto loop =
      virtual_frames(scanner, scene_named("board", scanner), pattern_set(sequence), {}, 1);
  VirtualCamera camera(loop);
  const FrameSet frames = take_window(camera, sequence, "the camera");
  ASSERT_EQ(frames.count(), frame_count(sequence));
  const FrameSet twice = joined({frames, frames});
  ASSERT_EQ(twice.count(), 2 * frame_count(sequence));
  twice.visit([&](const auto& views) {
    for (std::size_t n = 0; n < views.size(); ++n) {
      const auto& expected = std::get<Image<std::uint8_t>>(loop[n % loop.size()].pixels);
      EXPECT_EQ(views[n](30, 20), expected(30, 20));
    }
  });
}

}  // namespace slipstream::exposures_test
