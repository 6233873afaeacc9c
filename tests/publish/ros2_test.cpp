// The ROS 2 sink, read by a separate process over loopback through the public message
// definitions.
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <dds/dds.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "publish/dds_messages.h"
#include "ros2_messages.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"
#include "tests/io/small_disk.h"
#include "tests/publish/any_cloud.h"
#include "tests/publish/ros2_client.h"

namespace slipstream::ros2_test {
using namespace std::chrono_literals;

/// Memory shared by the publisher process and the test.
struct Shared {
  std::atomic<std::uint64_t> published = 0, saves = 0;
  std::atomic<bool> ill = false;
  static Shared* make() {
    void* memory =
        ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    return new (memory) Shared;
  }
};

/// A cloud whose first pixel has the intensity `number`.
Pooled<LiveCloud> numbered_cloud(std::uint64_t number) {
  Pooled<LiveCloud> cloud = any_cloud(number);
  cloud.fill().cloud.intensity(0, 0) = static_cast<float>(number);
  return cloud;
}

void publish_clouds(Shared& shared) {
  const auto sink = open_sink("ros2:/cell/scanner",
                              {.camera = camera(),
                               .statistics =
                                   [] {
                                     return R"({"findings":[{"what":"too dark","end":null},
                                                 {"what":"too bright","end":7}]})";
                                   },
                               .trouble = [&] { return shared.ill ? "the camera is gone" : ""; },
                               .save = [&] { return fmt::format("folder-{}", ++shared.saves); }});
  std::vector<Pooled<LiveCloud>> clouds;
  for (std::uint64_t number = 0; number < 50; ++number) clouds.push_back(numbered_cloud(number));
  while (true) {
    sink->put(clouds[shared.published++ % clouds.size()], false);
    std::this_thread::sleep_for(5ms);
  }
}

using PointCloud = sensor_msgs_msg_dds__PointCloud2_;
using Picture = sensor_msgs_msg_dds__Image_;
using Info = sensor_msgs_msg_dds__CameraInfo_;
using Request = std_srvs_srv_dds__Trigger_Request_;
using Response = std_srvs_srv_dds__Trigger_Response_;

bool equal_bits(float a, const std::uint8_t* b) {
  return std::memcmp(&a, b, sizeof a) == 0;
}

/// Checks the points and returns the cloud's number.
std::uint64_t expect_points(const PointCloud& message) {
  EXPECT_STREQ(message.header.frame_id, "camera");
  EXPECT_GT(message.header.stamp.sec, 1'700'000'000);
  EXPECT_EQ(message.height, 43U);
  EXPECT_EQ(message.width, 61U);
  EXPECT_EQ(message.point_step, 16U);
  EXPECT_EQ(message.row_step, 16U * 61);
  EXPECT_FALSE(message.is_bigendian);
  EXPECT_FALSE(message.is_dense);
  EXPECT_EQ(message.fields._length, 4U);
  constexpr std::array names{"x", "y", "z", "intensity"};
  for (std::uint32_t i = 0; i < message.fields._length; ++i) {
    EXPECT_STREQ(message.fields._buffer[i].name, names.at(i));
    EXPECT_EQ(message.fields._buffer[i].offset, 4 * i);
    EXPECT_EQ(message.fields._buffer[i].datatype, 7);
    EXPECT_EQ(message.fields._buffer[i].count, 1U);
  }
  EXPECT_EQ(message.data._length, 16U * 61 * 43);
  float number = 0;
  std::memcpy(&number, message.data._buffer + 12, sizeof number);
  const Pooled<LiveCloud> live = numbered_cloud(static_cast<std::uint64_t>(number));
  int different = 0;
  const std::uint8_t* at = message.data._buffer;
  for (std::size_t i = 0; i < live->cloud.z.pixel_count(); ++i, at += 16) {
    different += !equal_bits(live->cloud.x.begin()[i] / 1000, at) ||
                 !equal_bits(live->cloud.y.begin()[i] / 1000, at + 4) ||
                 !equal_bits(live->cloud.z.begin()[i] / 1000, at + 8) ||
                 !equal_bits(live->cloud.intensity.begin()[i], at + 12);
  }
  EXPECT_EQ(different, 0);
  return static_cast<std::uint64_t>(number);
}

void expect_camera(const Info& message) {
  EXPECT_EQ(message.width, 61U);
  EXPECT_EQ(message.height, 43U);
  EXPECT_STREQ(message.distortion_model, "plumb_bob");
  const std::vector<double> d(message.d._buffer, message.d._buffer + message.d._length);
  EXPECT_EQ(d, (std::vector<double>{-0.1, 0.05, 0.001, -0.002, 0.01}));
  EXPECT_EQ(std::vector<double>(message.k, message.k + 9),
            (std::vector<double>{80, 0, 30, 0, 82, 20, 0, 0, 1}));
  EXPECT_EQ(std::vector<double>(message.r, message.r + 9),
            (std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(std::vector<double>(message.p, message.p + 12),
            (std::vector<double>{80, 0, 30, 0, 0, 82, 20, 0, 0, 0, 1, 0}));
}

TEST(Ros2, ASubscriberByThePublicDefinitionsGetsEveryPointBitForBit) {
  choose_domain();
  Shared& shared = *Shared::make();
  const Child publisher([&] { publish_clouds(shared); });
  const Client client;
  const auto points =
      client.reader(sensor_msgs_msg_dds__PointCloud2__desc, "rt/cell/scanner/points");
  const auto image = client.reader(sensor_msgs_msg_dds__Image__desc, "rt/cell/scanner/image");
  const auto depth = client.reader(sensor_msgs_msg_dds__Image__desc, "rt/cell/scanner/depth");
  const auto camera_info =
      client.reader(sensor_msgs_msg_dds__CameraInfo__desc, "rt/cell/scanner/camera_info");
  std::set<std::uint64_t> numbers;
  std::map<std::int64_t, std::array<int, 2>> stamps;  // count of pictures, of depth images
  int cameras = 0;
  const bool all = wait_until([&] {
    take<PointCloud>(points, [&](const PointCloud& one) { numbers.insert(expect_points(one)); });
    take<Info>(camera_info, [&](const Info& one) {
      expect_camera(one);
      ++cameras;
    });
    take<Picture>(image, [&](const Picture& one) {
      EXPECT_STREQ(one.encoding, "mono8");
      EXPECT_EQ(one.step, 61U);
      ASSERT_EQ(one.data._length, 61U * 43);
      const Pooled<LiveCloud> live = numbered_cloud(one.data._buffer[0]);
      EXPECT_EQ(one.data._buffer[61 * 43 - 1], grey_level(live->cloud.intensity(60, 42)));
      ++stamps[one.header.stamp.sec * 1'000'000'000LL + one.header.stamp.nanosec][0];
    });
    take<Picture>(depth, [&](const Picture& one) {
      EXPECT_STREQ(one.encoding, "32FC1");
      EXPECT_EQ(one.step, 4U * 61);
      ASSERT_EQ(one.data._length, 4U * 61 * 43);
      ++stamps[one.header.stamp.sec * 1'000'000'000LL + one.header.stamp.nanosec][1];
    });
    std::this_thread::sleep_for(1ms);
    return numbers.size() >= 20 && cameras >= 20 && stamps.size() >= 20;
  });
  EXPECT_TRUE(all) << numbers.size() << " clouds";
  EXPECT_GE(std::count_if(stamps.begin(), stamps.end(),
                          [](const auto& one) {
                            return one.second == std::array{1, 1};
                          }),
            10)
      << "picture and depth of one cloud have one time";
}

struct Caller : ServiceCaller<Request, Response> {
  Caller(const Client& client, const std::string& name)
      : ServiceCaller(client, name, std_srvs_srv_dds__Trigger_Request__desc,
                      std_srvs_srv_dds__Trigger_Response__desc) {}
  std::pair<bool, std::string> call() {
    std::pair<bool, std::string> answer{false, "none came"};
    ServiceCaller::call({}, [&](const Response& told) { answer = {told.success, told.message}; });
    return answer;
  }
  std::pair<bool, std::string> call_until_true() {
    std::pair<bool, std::string> answer;
    wait_until([&] {
      if (!answer.first) answer = call();
      return answer.first;
    });
    return answer;
  }
};

using Answer = std::pair<bool, std::string>;

TEST(Ros2, ServicesSaveACloudAndSayWhatIsAmiss) {
  choose_domain();
  Shared& shared = *Shared::make();
  const Child publisher([&] { publish_clouds(shared); });
  const Client client;
  Caller capture(client, "cell/scanner/capture"), check(client, "cell/scanner/check");
  EXPECT_EQ(capture.call(), Answer(true, "folder-1"));
  EXPECT_EQ(check.call(), Answer(false, "too dark"));
  shared.ill = true;
  EXPECT_EQ(check.call(), Answer(false, "the camera is gone; too dark"));
  EXPECT_EQ(capture.call_until_true(), Answer(true, "folder-2"));
}

TEST(Ros2, SubscribersThatStopReadingOrSendGarbageOrGoAwayChangeNothing) {
  choose_domain();
  Shared& shared = *Shared::make();
  const Child publisher([&] { publish_clouds(shared); });
  const auto wait_for_more = [&](std::uint64_t more) {
    const std::uint64_t until = shared.published + more;
    return wait_until([&] {
      std::this_thread::sleep_for(1ms);
      return shared.published >= until;
    });
  };
  const auto listen = [] {
    const Client client;
    const auto reader =
        client.reader(sensor_msgs_msg_dds__PointCloud2__desc, "rt/cell/scanner/points");
    while (true) {
      take<PointCloud>(reader, [](const PointCloud&) {});
      std::this_thread::sleep_for(1ms);
    }
  };
  ASSERT_TRUE(wait_for_more(20));
  long before = 0;
  for (int round = 0; round < 4; ++round) {
    const Child stops(listen), goes(listen);
    ASSERT_TRUE(wait_for_more(40));
    ::kill(stops.process(), SIGSTOP);
    ASSERT_TRUE(wait_for_more(40));
    if (round == 0) before = publisher.resident_pages();
  }  // kills both
  EXPECT_LT(publisher.resident_pages(), before + 4000) << "pages";

  const Client client;
  const auto topic = create_message_topic(client.participant, "rq/cell/scanner/captureRequest",
                                          "std_srvs::srv::dds_::Trigger_Request_");
  const auto writer = dds_create_writer(client.participant, topic, nullptr, nullptr);
  std::this_thread::sleep_for(300ms);
  for (const std::size_t size : {4, 8, 16, 20, 4096, 8192, 100'000}) {
    for (const std::uint8_t byte : {0, 1, 255}) {
      const SharedMessage garbage = std::make_shared<RosMessage>(size, byte);
      EXPECT_EQ(dds_write(writer, &garbage), 0);
    }
  }
  EXPECT_EQ(Caller(client, "cell/scanner/check").call(), Answer(false, "too dark"));
  ASSERT_TRUE(wait_for_more(20));
}

TEST(Ros2, TheProgramSavesTheNewestCloudWhenAskedByService) {
  choose_domain();
  const TemporaryFolder folder;
  RunningProgram program({"live", "--source", "virtual", "--world", "ideal", "--camera", "160x120",
                          "--rate", "60", "--strategy", "pmp", "--steps", "4", "--headless",
                          "--save-to", folder.path().string(), "--publish", "ros2:scanner"});
  const Client client;
  Caller capture(client, "scanner/capture"), check(client, "scanner/check");
  const Answer saved = capture.call_until_true();
  ASSERT_TRUE(saved.first) << saved.second;
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(saved.second) / "cloud.ply"));
  EXPECT_EQ(check.call(), Answer(true, "OK: no problems found"));
  program.send(SIGINT);
  EXPECT_EQ(program.wait(), 0) << program.err();
}

TEST(Ros2, NamesThatROS2DoesNotTakeAreRefused) {
  for (const char* name :
       {"ros2:/", "ros2:a/", "ros2:a//b", "ros2:1a", "ros2:a__b", "ros2:a-b", "ros2:a b"}) {
    EXPECT_THROW(require_sink(name), Error) << name;
  }
  require_sink("ros2:/cell_1/scanner");
  ::setenv("ROS_DOMAIN_ID", "233", 1);
  EXPECT_THROW(open_sink("ros2:scanner", {}), Error);
  choose_domain();
  const auto sink = open_sink("ros2:scanner", {});
  EXPECT_THROW(open_sink("ros2:another", {}), Error) << "one ROS 2 namespace";
}

TEST(Ros2, OnlyThisMachineReachesTheSocketsOfROSLOCALHOSTONLY) {
  choose_domain();
  const auto sockets = [](bool bound) {
    int count = 0;
    for (int descriptor = 0; descriptor < 256; ++descriptor) {
      int type = 0;
      socklen_t size = sizeof(type);
      std::array<char, IFNAMSIZ> device{};
      socklen_t length = device.size();
      if (::getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) {
        continue;
      }
      sockaddr_in address{};
      socklen_t bytes = sizeof(address);
      ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &bytes);
      ::getsockopt(descriptor, SOL_SOCKET, SO_BINDTODEVICE, device.data(), &length);
      const bool local = std::string_view(device.data()) == "lo" ||
                         address.sin_addr.s_addr == htonl(INADDR_LOOPBACK);
      count += local == bound ? 1 : 0;
    }
    return count;
  };
  const int others = sockets(false);
  const auto sink = open_sink("ros2:scanner", {});
  EXPECT_EQ(sockets(false), others);
  EXPECT_GT(sockets(true), 1);
}

TEST(Ros2, SaysThatDescriptorsAreMissingBeforeAnyIsNeeded) {
  choose_domain();
  const FewDescriptors few(32);
  try {
    open_sink("ros2:scanner", {});
    FAIL();
  } catch (const WorldError& error) {
    EXPECT_NE(std::string(error.what()).find("needs 64 file descriptors"), std::string::npos)
        << error.what();
  }
}

TEST(Ros2, SaysWhyThereIsNoNetwork) {
  choose_domain();
  ::unsetenv("ROS_LOCALHOST_ONLY");
  ::setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"none\"/>"
           "</Interfaces></General></Domain></CycloneDDS>",
           1);
  try {
    open_sink("ros2:scanner", {});
    FAIL();
  } catch (const WorldError& error) {
    EXPECT_NE(std::string(error.what()).find(": none: "), std::string::npos) << error.what();
  }
}

}  // namespace slipstream::ros2_test
