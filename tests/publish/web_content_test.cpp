// What the page is sent, read back by the rules that its scripts follow.
#include "publish/web_content.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/publish/any_cloud.h"
#include "tests/publish/little_endian_reader.h"

namespace slipstream::web_content_test {

TEST(WebContent, CloudGivesBackEachPointWithinHalfAStep) {
  const Pooled<LiveCloud> live = any_cloud(5);
  const std::string rays = web_rays(camera()), bytes = web_cloud(*live);
  const std::size_t pixels = live->cloud.z.pixel_count();
  ASSERT_EQ(rays.size(), 8 * pixels);
  ASSERT_EQ(bytes.size(), 24 + 3 * pixels);
  LittleEndianReader message{{reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}};
  EXPECT_EQ(message.get<std::int32_t>(), size.width);
  EXPECT_EQ(message.get<std::int32_t>(), size.height);
  EXPECT_EQ(message.get<std::int32_t>(), 1);
  EXPECT_EQ(message.get<std::int32_t>(), static_cast<std::int32_t>(point_count(live->cloud)));
  const auto nearest = message.get<float>(), step = message.get<float>();
  EXPECT_LT(step, 0.005F) << "of 300 mm";
  std::vector<float> u(2 * pixels);
  std::memcpy(u.data(), rays.data(), rays.size());
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto steps = message.get<std::uint16_t>();
    const float true_z = live->cloud.z.begin()[i];
    ASSERT_EQ(steps == 0, std::isnan(true_z));
    if (steps == 0) continue;
    const float z = nearest + static_cast<float>(steps - 1) * step;
    EXPECT_NEAR(z, true_z, 0.51F * step + 1e-4F);
    EXPECT_NEAR(u[2 * i] * z, live->cloud.x.begin()[i], step);
    EXPECT_NEAR(u[2 * i + 1] * z, live->cloud.y.begin()[i], step);
  }
  EXPECT_EQ(message.get<std::uint8_t>(), grey_level(live->cloud.intensity(0, 0)));
}

TEST(WebContent, CloudThinsLargePicturesAndShowsFramesWhereThereAreNoPoints) {
  EXPECT_EQ(web_step({640, 480}), 1);
  EXPECT_EQ(web_step({4096, 3000}), 4);
  Pooled<LiveCloud> live = any_cloud(1);
  live.fill().cloud = Cloud();
  Frame frame(FrameFormat{size, 12});
  std::get<Image<std::uint16_t>>(frame.pixels)(0, 0) = 0xabc;
  Pool<Frame> frames(1, [&] { return frame; });
  live.fill().frames.assign(1, frames.take());
  const std::string bytes = web_cloud(*live);
  ASSERT_EQ(bytes.size(), 24U + 3U * 61 * 43);
  EXPECT_EQ(static_cast<std::uint8_t>(bytes[24 + 2 * 61 * 43]), 0xab);
}

TEST(WebContent, CloudHasTheColoursBeforeThePhase) {
  const Pooled<LiveCloud> live = coloured_cloud();
  const std::size_t pixels = live->cloud.z.pixel_count();
  const std::string bytes = web_cloud(*live, Image<std::uint8_t>(size, 9));
  ASSERT_EQ(bytes.size(), 24 + (2 + 1 + 3 + 1) * pixels);
  EXPECT_EQ(bytes[8], 3) << "depth and colours";
  EXPECT_EQ(std::memcmp(bytes.data() + 24 + 3 * pixels, live->cloud.colour.begin(), 3 * pixels), 0);
  EXPECT_EQ(bytes.back(), 9);
}

TEST(WebContent, MetricsNamesWhatTheStatisticsSay) {
  EXPECT_EQ(metrics_of(R"({"frames": {"lost": 2}, "latency_ms": {"p99": 1.5}, "source": "virtual",
                           "stages": [{"name": "a\"b", "rate": 3, "done": 4}], "findings": [{}, {}],
                           "track": {"centre_mm": [1, 2]}, "model": null})"),
            R"(# TYPE slipstream_findings gauge
slipstream_findings 2
# TYPE slipstream_frames_lost_total counter
slipstream_frames_lost_total 2
# TYPE slipstream_latency_ms_p99 gauge
slipstream_latency_ms_p99 1.5
# TYPE slipstream_stages_done_total counter
slipstream_stages_done_total{name="a\"b"} 4
# TYPE slipstream_stages_rate gauge
slipstream_stages_rate{name="a\"b"} 3
# TYPE slipstream_track_centre_mm gauge
slipstream_track_centre_mm{index="0"} 1
slipstream_track_centre_mm{index="1"} 2
)");
}

}  // namespace slipstream::web_content_test
