// An engine defined outside the library: it returns the same cloud for all frames, as a test double
// for code that uses an engine.
#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "tests/extensions/seen.h"

namespace slipstream::own_engine_test {

std::shared_ptr<const CustomEngine> flat_wall(float z) {
  return std::make_shared<CustomEngine>(CustomEngine{
      "flat wall", [z](const FrameViews& frames, const Outputs& outputs) {
        if (outputs.cloud == nullptr) return;
        *outputs.cloud = Cloud(frames.size());
        outputs.cloud->x = outputs.cloud->y = Image<float>(frames.size());
        outputs.cloud->z = Image<float>(frames.size(), z);
        std::fill(outputs.cloud->validity.begin(), outputs.cloud->validity.end(), Validity::valid);
      }});
}

TEST(EngineDouble, CustomEngineIsChosenOnceAndCleanedLikeOthers) {
  Seen seen = seen_under(DualFrequency{});
  seen.setup.settings.clean = CleanSettings::none();
  seen.setup.settings.clean.box = PointBox{{-1000, -1000, 0}, {1000, 1000, 500}};
  for (const float z : {400.0F, 600.0F}) {
    seen.setup.settings.custom_engine = flat_wall(z);
    Engine engine(seen.setup);
    Cloud cloud;
    engine.cloud(seen.scan.frames, cloud);
    EXPECT_EQ(engine.backend_for(seen.scan.frames), "flat wall");
    EXPECT_EQ(point_count(cloud), z < 500 ? cloud.z.pixel_count() : 0U);
  }
}

}  // namespace slipstream::own_engine_test
