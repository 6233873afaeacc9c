// Tracks a sphere and a plane from cloud to cloud, and merges clouds into a model.
#include <chrono>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "live/followed_object-inl.h"
#include "live/object_tracker.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/virtual_scanner.h"
#include "tests/live/scripted_source.h"
#include "tests/live/virtual_loop.h"

namespace slipstream::object_track_test {
using Vector = Eigen::Vector3d;

constexpr double frame_rate = 120;

/// Calls `on_cloud` with the cloud of each motion window of a moving scene and the frame number of
/// the window's middle.
template <class OnCloud>
void each_cloud(const Scanner& scanner, const Scene& scene, int frames, const OnCloud& on_cloud) {
  const Sequence cycle{.strategy = PhaseMeasuring{.steps = 4, .frequency = 1}, .motion = 2};
  const PatternSet patterns = pattern_set(cycle);
  const Photometry photometry{.noise_variance = 0.01, .bits = 12};
  Engine engine(scanner, cycle);
  Cloud cloud;
  for (int first = 0; first < frames; ++first) {
    const VirtualScan scan = take_scan(scanner, scene, patterns, photometry, first);
    engine.cloud(scan.frames, cloud);
    on_cloud(cloud, first + 0.5 * (patterns.count - 1));
  }
}

TEST(ObjectTracker, FollowsASphereAt20MillimetresPerSecond) {
  const Scanner scanner = example_scanner({160, 120});
  const Vector velocity(16, 0, 12);  // mm/s
  Scene scene = scene_named("sphere", scanner);
  scene.front().motion.step = velocity / frame_rate;
  const Vector centre = scene.front().pose.translation();
  ObjectTracker tracker({std::get<Sphere>(scene.front().shape).radius});
  double farthest = 0;
  each_cloud(scanner, scene, 20, [&](const Cloud& cloud, double time) {
    tracker.look(cloud, 7 + time / frame_rate);
    const Vector truth = centre + time / frame_rate * velocity;
    farthest = std::max(farthest, (tracker.track().place - truth).norm());
  });
  const ObjectTrack& track = tracker.track();
  EXPECT_EQ(track.found, 20U);
  EXPECT_EQ(track.looked, 20U);
  RecordProperty("farthest", std::to_string(farthest));
  RecordProperty("speed_off", std::to_string((track.velocity - velocity).norm()));
  RecordProperty("residual", std::to_string(track.residuals.rms));
  EXPECT_LT(farthest, 0.05);
  EXPECT_LT((track.velocity - velocity).norm(), 0.3);
  EXPECT_LT(track.residuals.rms, 1);
}

TEST(ObjectTracker, FollowsAPlaneAlongItsNormal) {
  const Scanner scanner = example_scanner({160, 120});
  Scene scene = scene_named("board", scanner);
  scene.front().motion.step = Vector(5, 3, 20) / frame_rate;
  const Vector normal = -scene.front().pose.linear().col(2);
  ObjectTracker tracker({});
  each_cloud(scanner, scene, 12, [&](const Cloud& cloud, double time) {
    tracker.look(cloud, time / frame_rate);
    const Vector on_plane = scene.front().pose.translation() + time * scene.front().motion.step;
    EXPECT_NEAR((tracker.track().place - on_plane).dot(normal), 0, 0.05);
  });
  EXPECT_GT(tracker.track().normal.dot(normal), 1 - 1e-6);
  const double speed = Vector(5, 3, 20).dot(normal);
  EXPECT_NEAR(tracker.track().velocity.dot(normal), speed, 1);
  EXPECT_NEAR(tracker.track().velocity.norm(), std::abs(speed), 1);
}

TEST(ObjectTracker, LosesWhatIsNotThereAndFindsItAgain) {
  const Scanner scanner = example_scanner({160, 120});
  const Scene scene = scene_named("sphere", scanner);
  ObjectTracker tracker({std::get<Sphere>(scene.front().shape).radius});
  double seconds = 0;
  each_cloud(scanner, scene, 3, [&](const Cloud& cloud, double) {
    tracker.look(cloud, ++seconds);
    tracker.look(Cloud({160, 120}), ++seconds);
  });
  EXPECT_EQ(tracker.track().found, 3U);
  EXPECT_EQ(tracker.track().looked, 6U);
  EXPECT_EQ(tracker.track().velocity.norm(), 0);
}

TEST(ObjectTrack, TrackedShapeIsASphereOrAPlane) {
  EXPECT_EQ(tracked_shape_named("sphere:12.5").radius, 12.5);
  EXPECT_FALSE(tracked_shape_named("plane").radius);
  for (const char* bad : {"", "sphere", "sphere:", "sphere:0", "sphere:-1", "sphere:1mm",
                          "sphere:nan", "sphere:inf", "plane:3", "cube:1"}) {
    EXPECT_THROW((void)tracked_shape_named(bad), Error) << bad;
  }
}

TEST(ObjectTrack, FollowedObjectTimesACloudByOneClockThoughThatBeginsAtZero) {
  using namespace std::chrono_literals;
  Pool<Frame> pool(2, [] { return Frame(); });
  LiveCloud cloud;
  for (const std::chrono::nanoseconds time : {0ms, 100ms}) {
    Pooled<Frame> frame = pool.take();
    FrameStamp& stamp = frame.fill().stamp;
    stamp.device_time = time;
    stamp.host_time = std::chrono::steady_clock::now();
    cloud.frames.push_back(frame);
  }
  EXPECT_DOUBLE_EQ(seconds_of(cloud), 0.05);
}

TEST(ObjectTrack, LivePipelineFollowsAnObjectAndMakesAModel) {
  const Scanner scanner = example_scanner({160, 120});
  const Scene scene = scene_named("sphere", scanner);
  const double radius = std::get<Sphere>(scene.front().shape).radius;
  const Strategy strategy = PhaseMeasuring{.steps = 4, .frequency = 1};
  auto camera = std::make_unique<VirtualCamera>(
      virtual_frames(scanner, scene, pattern_set(strategy, Axis::x), {.bits = 10}, 2));
  LivePipeline pipeline(std::move(camera), {scanner, {.strategy = strategy}},
                        {.most_frames = 60, .track = TrackedShape{radius}, .model = true});
  EXPECT_TRUE(pipeline.model().cloud.z.empty());
  run_to_its_end(pipeline);
  EXPECT_EQ(pipeline.failure(), nullptr);
  const LiveStatistics statistics = pipeline.statistics();
  ASSERT_TRUE(statistics.track && statistics.model);
  EXPECT_GT(statistics.track->found, 0U);
  EXPECT_EQ(statistics.track->looked + statistics.track->missed, statistics.clouds);
  EXPECT_EQ(static_cast<std::uint64_t>(statistics.model->views + statistics.model->left_out) +
                statistics.model->missed,
            statistics.clouds);
  EXPECT_NE(text_of(statistics).find("mm/s; found in"), std::string::npos);
  EXPECT_GT(pipeline.model().cloud.size().width, 1000);
}

}  // namespace slipstream::object_track_test
