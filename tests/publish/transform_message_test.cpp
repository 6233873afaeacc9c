#include "publish/transform_message.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "geometry/rotation.h"
#include "io/file.h"
#include "publish/cdr.h"
#include "publish/mcap_reader.h"
#include "publish/scan3d.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"
#include "tests/io/temporary_folder.h"
#include "tests/publish/any_cloud.h"

namespace slipstream::transform_message_test {

std::shared_ptr<const FramePose> base_pose() {
  return std::make_shared<const FramePose>(
      FramePose{"camera", "robot_base",
                pose_from(rotation_of_euler({0.3, -0.2, 2.9}, {}), {900, -250, 1400})});
}

/// The first message of each topic of a file written with a frame, and the topics in order.
struct WrittenFile {
  std::map<std::string, std::vector<std::uint8_t>> first;
  std::vector<std::string> order;
};

WrittenFile written(const PublishedRun& run) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "clouds.mcap";
  const auto sink = open_sink("mcap:" + path.string(), run);
  for (std::uint64_t i = 0; i < 3; ++i) sink->put(any_cloud(4 * i), false);
  sink->finish();

  WrittenFile file;
  EXPECT_TRUE(read_mcap(path, [&](const McapMessage& message) {
    file.order.push_back(message.topic);
    file.first.try_emplace(message.topic, message.content.begin(), message.content.end());
  }));
  return file;
}

/// The frame_id of a message with a header.
std::string frame_id(const std::vector<std::uint8_t>& message) {
  CdrReader cdr(message);
  cdr.count();
  cdr.count();
  return std::string(cdr.text());
}

TEST(TransformMessage, ReturnsThePose) {
  RosMessage message;
  write_transform(*base_pose(), "left_camera", 1'700'000'000'000'000'000, message);
  const std::vector<FramePose> poses = read_transforms(message);

  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses[0].from, "left_camera");
  EXPECT_EQ(poses[0].to, "robot_base");
  EXPECT_TRUE(poses[0].transform.isApprox(base_pose()->transform, 1e-9));
}

TEST(TransformMessage, RefusesDamagedMessages) {
  RosMessage message;
  write_transform(*base_pose(), "camera", 0, message);
  for (std::size_t size = 0; size < message.size(); ++size) {
    const RosMessage cut(message.begin(), message.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(read_transforms(cut), Error) << size;
  }
}

TEST(TransformMessage, McapHasPointsInTheFrameAndTheRestInTheCameras) {
  const WrittenFile file = written({.camera = camera(), .frame = base_pose()});
  EXPECT_EQ(frame_id(file.first.at("/points")), "robot_base");
  EXPECT_EQ(frame_id(file.first.at("/image")), "camera");
  EXPECT_EQ(frame_id(file.first.at("/camera_info")), "camera");

  // The transform comes once, before any cloud.
  EXPECT_EQ(std::ranges::count(file.order, "/tf_static"), 1);
  EXPECT_EQ(file.order.front(), "/tf_static");
  const FramePose pose = read_transforms(file.first.at("/tf_static")).at(0);
  EXPECT_EQ(pose.to, "robot_base");
  EXPECT_EQ(pose.from, "camera");

  // The points, in metres.
  const Cloud given = any_cloud(0)->cloud;
  const StoredCloud stored = read_point_cloud(file.first.at("/points"));
  EXPECT_EQ(frame_name(stored.cloud), "robot_base");
  for_each_pixel_in_order(size, [&](int column, int row) {
    ASSERT_EQ(stored.cloud.validity(column, row) == Validity::valid,
              given.validity(column, row) == Validity::valid);
    if (given.validity(column, row) != Validity::valid) return;
    const Eigen::Vector3d expected = pose.transform * position_at(given, column, row);
    EXPECT_LT((position_at(stored.cloud, column, row) - expected).norm(), 1e-2);
  });
}

TEST(TransformMessage, McapWithoutAFrameHasNone) {
  const WrittenFile file = written({.camera = camera()});
  EXPECT_FALSE(file.first.contains("/tf_static"));
  EXPECT_EQ(frame_id(file.first.at("/points")), "camera");
  EXPECT_EQ(frame_name(read_point_cloud(file.first.at("/points")).cloud), camera_frame);
}

TEST(TransformMessage, GenicamCameraTellsThePoseOfItsAnchor) {
  using namespace scan3d;
  const std::shared_ptr<const FramePose> frame = base_pose();
  const std::vector<std::uint8_t> memory =
      scan3d_memory("127.0.0.1", {.camera = camera(), .frame = frame}, {}, 1234);
  const auto value = [&](std::uint32_t i) {
    const auto bits = number_at<std::uint32_t, std::endian::big>(
        memory, static_cast<std::uint32_t>(at(reference_value, i)));
    return double{std::bit_cast<float>(bits)};
  };

  // P' = Rz Ry Rx P + T, as the description says.
  const auto turn = [&](int axis) {
    return Eigen::AngleAxisd(value(static_cast<std::uint32_t>(axis)) * degree,
                             Eigen::Vector3d::Unit(axis))
        .toRotationMatrix();
  };
  const Eigen::Matrix3d rotation = turn(2) * turn(1) * turn(0);
  EXPECT_LT((rotation - frame->transform.linear()).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_NEAR(value(3), 900, 1e-3);
  EXPECT_NEAR(value(5), 1400, 1e-3);

  const std::string all(memory.begin(), memory.end());
  EXPECT_EQ(all.substr(frame_text, 11), std::string("robot_base\0", 11));
  EXPECT_NE(all.find("Scan3dCoordinateReferenceValue"), std::string::npos);

  // Without a frame the description is as it was.
  const std::vector<std::uint8_t> plain =
      scan3d_memory("127.0.0.1", {.camera = camera()}, {}, 1234);
  EXPECT_EQ(std::string(plain.begin(), plain.end()).find("CoordinateReferenceSelector"),
            std::string::npos);
}

}  // namespace slipstream::transform_message_test
