// The sink for ROS 2 as a program sees it that reads by the public definitions of the messages: in
// a process of its own, over the network of this machine.
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include <dds/dds.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "ros2_messages.h"
#include "slipstream/error/error.h"
#include "slipstream/publish/dds_messages.h"
#include "slipstream/publish/named_sink.h"
#include "tests/app/program.h"
#include "tests/publish/any_cloud.h"

namespace slipstream {
namespace {
using namespace std::chrono_literals;

/// A domain that no other test uses at the same time, on this machine alone and without multicast.
void choose_domain() {
  ::setenv("ROS_DOMAIN_ID", std::to_string(1 + ::getpid() % 200).c_str(), 1);
  ::setenv("ROS_LOCALHOST_ONLY", "1", 1);
  ::setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast>"
           "<Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces></General>"
           "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
           "<Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery>"
           "<Internal><SocketReceiveBufferSize min=\"4MB\"/></Internal></Domain></CycloneDDS>",
           1);
}

/// Another process that does something, and is killed if it has not ended.
class Child {
 public:
  explicit Child(const std::function<void()>& work) : process_(::fork()) {
    if (process_ != 0) return;
    work();
    ::_exit(0);
  }
  ~Child() {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  [[nodiscard]] pid_t process() const { return process_; }

  [[nodiscard]] long resident_pages() const {
    std::ifstream file(fmt::format("/proc/{}/statm", process_));
    long all = 0, resident = 0;
    file >> all >> resident;
    return resident;
  }

 private:
  pid_t process_;
};

/// What publisher and test both see.
struct Shared {
  std::atomic<std::uint64_t> published = 0, saves = 0;
  std::atomic<bool> ill = false;
  static Shared* make() {
    void* memory =
        ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    return new (memory) Shared;
  }
};

/// A cloud with its number as the first pixel's intensity.
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
    sink->put(clouds[shared.published++ % clouds.size()]);
    std::this_thread::sleep_for(5ms);
  }
}

/// A program of ROS 2.
struct Client {
  Client() {
    choose_domain();
    const auto id = static_cast<dds_domainid_t>(std::atoi(std::getenv("ROS_DOMAIN_ID")));
    participant = dds_create_participant(id, nullptr, nullptr);
  }
  ~Client() { dds_delete(participant); }

  [[nodiscard]] dds_entity_t reader(const dds_topic_descriptor_t& type, const std::string& name,
                                    bool reliable = false, bool lasting = false) const {
    dds_qos_t* const qos = dds_create_qos();
    if (lasting) dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                         DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 5);
    const auto topic = dds_create_topic(participant, &type, name.c_str(), nullptr, nullptr);
    const auto made = dds_create_reader(participant, topic, qos, nullptr);
    dds_delete_qos(qos);
    return made;
  }

  dds_entity_t participant;
};

/// Whether it saw one; `see` is called for each that has come.
template <class Message>
bool take(dds_entity_t reader, const std::function<void(const Message&)>& see) {
  void* sample = nullptr;
  dds_sample_info_t info;
  bool saw = false;
  while (dds_take(reader, &sample, &info, 1, 1) == 1) {
    if (info.valid_data) {
      see(*static_cast<const Message*>(sample));
      saw = true;
    }
    dds_return_loan(reader, &sample, 1);
    sample = nullptr;
  }
  return saw;
}

using PointCloud = sensor_msgs_msg_dds__PointCloud2_;
using Picture = sensor_msgs_msg_dds__Image_;
using Info = sensor_msgs_msg_dds__CameraInfo_;
using Request = std_srvs_srv_dds__Trigger_Request_;
using Response = std_srvs_srv_dds__Trigger_Response_;

bool equal_bits(float a, const std::uint8_t* b) {
  return std::memcmp(&a, b, sizeof a) == 0;
}

/// The cloud's number.
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

TEST(Ros2, a_subscriber_by_the_public_definitions_gets_every_point_bit_for_bit) {
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
  std::map<std::int64_t, std::array<int, 2>> stamps;  // of pictures, of depths
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

/// Calls a service until it answers, as a client of ROS 2 over Cyclone DDS does.
template <class Request, class Response>
struct ServiceCaller {
  ServiceCaller(const Client& client, const std::string& name,
                const dds_topic_descriptor_t& request, const dds_topic_descriptor_t& response) {
    const auto topic = dds_create_topic(client.participant, &request,
                                        ("rq/" + name + "Request").c_str(), nullptr, nullptr);
    writer = dds_create_writer(client.participant, topic, nullptr, nullptr);
    reader = client.reader(response, "rr/" + name + "Reply", true);
    wait_until([&] {
      std::this_thread::sleep_for(5ms);
      dds_publication_matched_status_t to{};
      dds_subscription_matched_status_t from{};
      dds_get_publication_matched_status(writer, &to);
      dds_get_subscription_matched_status(reader, &from);
      return to.current_count > 0 && from.current_count > 0;
    });
  }
  void call(Request request, const std::function<void(const Response&)>& see) {
    request.guid = 0xfedcba9876543210U;
    request.seq = ++number;
    dds_write(writer, &request);
    bool came = false;
    wait_until([&] {
      std::this_thread::sleep_for(1ms);
      came = came || take<Response>(reader, [&](const Response& told) {
               EXPECT_EQ(told.guid, request.guid);
               EXPECT_EQ(told.seq, number);
               see(told);
             });
      return came;
    });
    EXPECT_TRUE(came);
  }

  dds_entity_t writer, reader;
  std::int64_t number = 0;
};

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

TEST(Ros2, services_save_a_cloud_and_say_what_is_amiss) {
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

// Those of ROS 2's parameters.
#define OF_PARAMETERS(What)                                            \
  ServiceCaller<rcl_interfaces_srv_dds__##What##Parameters_Request_,   \
                rcl_interfaces_srv_dds__##What##Parameters_Response_>( \
      client, "cell/scanner/" + name_of(#What),                        \
      rcl_interfaces_srv_dds__##What##Parameters_Request__desc,        \
      rcl_interfaces_srv_dds__##What##Parameters_Response__desc)

std::string name_of(const std::string& what) {
  return static_cast<char>(what[0] - 'A' + 'a') + what.substr(1) + "_parameters";
}

using Value = rcl_interfaces_msg_dds__ParameterValue_;
using Parameter = rcl_interfaces_msg_dds__Parameter_;
using Event = rcl_interfaces_msg_dds__ParameterEvent_;

char* text(const char* letters) {
  return const_cast<char*>(letters);
}
template <class Given>
Value value_of(Given given) {
  Value value{};
  value.string_value = text("");
  if constexpr (std::is_same_v<Given, bool>) {
    value.type = 1;
    value.bool_value = given;
  } else if constexpr (std::is_same_v<Given, int>) {
    value.type = 2;
    value.integer_value = given;
  } else if constexpr (std::is_same_v<Given, double>) {
    value.type = 3;
    value.double_value = given;
  } else {
    value.type = 4;
    value.string_value = text(given);
  }
  return value;
}
/// "3: 20", as the value's type is.
std::string text_of(const Value& value) {
  return fmt::format("{}: {}", value.type,
                     value.type == 1   ? (value.bool_value ? "true" : "false")
                     : value.type == 3 ? fmt::format("{}", value.double_value)
                                       : value.string_value);
}
template <class Sequence, class Tell>
std::vector<std::string> all(const Sequence& sequence, Tell tell) {
  std::vector<std::string> texts;
  for (std::uint32_t i = 0; i < sequence._length; ++i) texts.push_back(tell(sequence._buffer[i]));
  return texts;
}
std::string named(const Parameter& parameter) {
  return fmt::format("{} {}", parameter.name, text_of(parameter.value));
}
using Texts = std::vector<std::string>;

void publish_settings() {
  std::mutex mutex;
  std::vector<RunSetting> settings{
      {.name = "min-modulation",
       .help = "least modulation",
       .unit = "grey levels",
       .value = "15",
       .most = 127},
      {.name = "record", .help = "all frames", .value = "off", .choices = {"off", "on"}},
      {.name = "strategy", .help = "what is shown", .value = "PMP", .choices = {"PMP", "Gray"}}};
  const auto sink =
      open_sink("ros2:/cell/scanner", {.camera = camera(),
                                       .settings =
                                           [&] {
                                             const std::lock_guard lock(mutex);
                                             return settings;
                                           },
                                       .change =
                                           [&](const std::string& name, const std::string& value) {
                                             const std::lock_guard lock(mutex);
                                             require_settable(settings, name, value);
                                             for (RunSetting& one : settings) {
                                               if (one.name == name) one.value = value;
                                             }
                                           }});
  while (true) std::this_thread::sleep_for(100ms);
}

TEST(Ros2, settings_are_a_nodes_parameters) {
  choose_domain();
  const Child publisher(publish_settings);
  const Client client;
  const auto events =
      client.reader(rcl_interfaces_msg_dds__ParameterEvent__desc, "rt/parameter_events", true);
  std::vector<Texts> come, changed;
  const auto hear = [&] {
    take<Event>(events, [&](const Event& event) {
      EXPECT_STREQ(event.node, "/cell/scanner");
      EXPECT_EQ(event.deleted_parameters._length, 0U);
      if (event.new_parameters._length > 0) come.push_back(all(event.new_parameters, named));
      if (event.changed_parameters._length > 0) {
        changed.push_back(all(event.changed_parameters, named));
      }
    });
  };
  const auto nodes = client.reader(rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc,
                                   "ros_discovery_info", true, true);
  Texts known;
  wait_until([&] {
    take<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_>(nodes, [&](const auto& info) {
      known = all(info.node_entities_info_seq, [](const auto& node) {
        return fmt::format("{} {}", node.node_namespace, node.node_name);
      });
    });
    std::this_thread::sleep_for(1ms);
    return !known.empty();
  });
  EXPECT_EQ(known, Texts{"/cell scanner"});
  wait_until([&] {
    dds_subscription_matched_status_t from{};
    dds_get_subscription_matched_status(events, &from);
    std::this_thread::sleep_for(1ms);
    return from.current_count > 0;
  });

  const Texts names{"min-modulation", "record", "strategy"};
  OF_PARAMETERS(List).call({}, [&](const auto& answer) {
    EXPECT_EQ(all(answer.names, [](const char* name) { return name; }), names);
    EXPECT_EQ(answer.prefixes._length, 0U);
  });
  std::array asked{text("strategy"), text("nothing"), text("record"), text("min-modulation")};
  auto getter = OF_PARAMETERS(Get);
  rcl_interfaces_srv_dds__GetParameters_Request_ of_these{};
  of_these.names = {4, 4, asked.data(), false};
  const auto get = [&] {
    Texts values;
    getter.call(of_these, [&](const auto& answer) { values = all(answer.values, text_of); });
    return values;
  };
  EXPECT_EQ(get(), (Texts{"4: PMP", "0: ", "1: false", "3: 15"}));
  rcl_interfaces_srv_dds__DescribeParameters_Request_ what{};
  what.names = of_these.names;
  OF_PARAMETERS(Describe).call(what, [&](const auto& answer) {
    ASSERT_EQ(answer.descriptors._length, 4U);
    const auto& [strategy, nothing, record, number] =
        *reinterpret_cast<std::array<rcl_interfaces_msg_dds__ParameterDescriptor_, 4>*>(
            answer.descriptors._buffer);
    EXPECT_STREQ(strategy.additional_constraints, "PMP; Gray");
    EXPECT_EQ(nothing.type, 0);
    EXPECT_STREQ(nothing.name, "nothing");
    EXPECT_EQ(record.type, 1);
    EXPECT_STREQ(number.description, "least modulation, grey levels");
    ASSERT_EQ(number.floating_point_range._length, 1U);
    EXPECT_EQ(number.floating_point_range._buffer[0].from_value, 0);
    EXPECT_EQ(number.floating_point_range._buffer[0].to_value, 127);
  });
  auto setter = OF_PARAMETERS(Set);
  const auto set = [&](std::vector<Parameter> wishes) {
    Texts outcomes;
    const auto count = static_cast<std::uint32_t>(wishes.size());
    rcl_interfaces_srv_dds__SetParameters_Request_ request{};
    request.parameters = {count, count, wishes.data(), false};
    setter.call(request, [&](const auto& answer) {
      outcomes = all(answer.results, [](const auto& result) {
        return result.successful ? "done" : std::string(result.reason);
      });
    });
    return outcomes;
  };
  EXPECT_EQ(set({{text("min-modulation"), value_of(20)},
                 {text("min-modulation"), value_of(200.5)},
                 {text("record"), value_of(true)},
                 {text("strategy"), value_of("Grey")},
                 {text("strateg"), value_of("Gray")},
                 {text("strategy"), value_of("Gray")}}),
            (Texts{"done", "min-modulation '200.5': a number from 0 to 127 grey levels is wanted",
                   "done", "strategy 'Grey': wanted is one of: PMP; Gray; did you mean Gray?",
                   "there is no setting 'strateg' now; did you mean strategy?; there are "
                   "min-modulation, record, strategy",
                   "done"}));
  EXPECT_EQ(get(), (Texts{"4: Gray", "0: ", "1: true", "3: 20"}));
  std::vector<Parameter> wishes{{text("min-modulation"), value_of(30.0)},
                                {text("record"), value_of("perhaps")}};
  rcl_interfaces_srv_dds__SetParametersAtomically_Request_ both{};
  both.parameters = {2, 2, wishes.data(), false};
  ServiceCaller<rcl_interfaces_srv_dds__SetParametersAtomically_Request_,
                rcl_interfaces_srv_dds__SetParametersAtomically_Response_>(
      client, "cell/scanner/set_parameters_atomically",
      rcl_interfaces_srv_dds__SetParametersAtomically_Request__desc,
      rcl_interfaces_srv_dds__SetParametersAtomically_Response__desc)
      .call(both, [](const auto& answer) {
        EXPECT_FALSE(answer.result.successful);
        EXPECT_STREQ(answer.result.reason, "record 'perhaps': wanted is one of: off; on");
      });
  EXPECT_EQ(get(), (Texts{"4: Gray", "0: ", "1: true", "3: 20"}));
  wait_until([&] {
    hear();
    std::this_thread::sleep_for(1ms);
    Texts last;
    for (const Texts& some : changed) last.insert(last.end(), some.begin(), some.end());
    return last.size() >= 3;
  });
  // What was there at the start may have been told before anybody could hear it.
  for (const Texts& one : come) {
    EXPECT_EQ(one, (Texts{"min-modulation 3: 15", "record 1: false", "strategy 4: PMP"}));
  }
  Texts last;
  for (const Texts& some : changed) last.insert(last.end(), some.begin(), some.end());
  EXPECT_EQ(last, (Texts{"min-modulation 3: 20", "record 1: true", "strategy 4: Gray"}));
}

TEST(Ros2, subscribers_that_stop_reading_or_send_garbage_or_go_away_change_nothing) {
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
  }  // and are killed
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

TEST(Ros2, the_program_saves_the_newest_cloud_when_asked_by_service) {
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
  EXPECT_EQ(check.call(), Answer(true, "nothing is amiss"));
  program.send(SIGINT);
  EXPECT_EQ(program.wait(), 0) << program.err();
}

TEST(Ros2, names_that_ROS_2_does_not_take_are_refused) {
  for (const char* name :
       {"ros2:/", "ros2:a/", "ros2:a//b", "ros2:1a", "ros2:a__b", "ros2:a-b", "ros2:a b"}) {
    EXPECT_THROW(require_sink(name), Error) << name;
  }
  require_sink("ros2:/cell_1/scanner");
  ::setenv("ROS_DOMAIN_ID", "233", 1);
  EXPECT_THROW(open_sink("ros2:scanner", {}), Error);
  choose_domain();
  const auto sink = open_sink("ros2:scanner", {});
  EXPECT_THROW(open_sink("ros2:another", {}), Error) << "one namespace";
}

TEST(Ros2, says_why_there_is_no_network) {
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

}  // namespace
}  // namespace slipstream
