// Settings of a run as parameters of a ROS 2 node, read through the public service definitions.
#include <array>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include <dds/dds.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "publish/cdr.h"
#include "publish/ros_parameters.h"
#include "ros2_messages.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"
#include "tests/publish/any_cloud.h"
#include "tests/publish/ros2_client.h"

namespace slipstream::ros2_parameters_test {
using namespace std::chrono_literals;

// Caller of a ROS 2 parameter service, e.g. OF_PARAMETERS(Get).
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
/// Type and value, e.g. "3: 20".
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

TEST(Ros2Parameters, ParametersAreNotSetWhileTheRunCannotTellThem) {
  const PublishedRun run{
      .settings = []() -> std::vector<RunSetting> { throw WorldError("the camera shuts down"); }};
  RosMessage request, reply;
  Cdr(request).add_count(1).add_text("record");
  for (const RosService& service : parameter_services("scanner", run)) {
    if (service.name != "scanner/get_parameters") continue;
    CdrReader asked(request);
    Cdr answer(reply);
    service.answer(asked, answer);
  }
  CdrReader answered(reply);
  EXPECT_EQ(answered.count(), 1U);
  EXPECT_EQ(answered.get<std::uint8_t>(), 0) << "the type of a parameter that is not set";
}

TEST(Ros2Parameters, SettingsAreANodesParameters) {
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
            (Texts{"done", "min-modulation '200.5': expected a number from 0 to 127 grey levels",
                   "done", "strategy 'Grey': expected one of: PMP; Gray; did you mean Gray?",
                   "there is no setting 'strateg' now; did you mean strategy?; available: "
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
        EXPECT_STREQ(answer.result.reason, "record 'perhaps': expected one of: off; on");
      });
  EXPECT_EQ(get(), (Texts{"4: Gray", "0: ", "1: true", "3: 20"}));
  wait_until([&] {
    hear();
    std::this_thread::sleep_for(1ms);
    Texts last;
    for (const Texts& some : changed) last.insert(last.end(), some.begin(), some.end());
    return last.size() >= 3;
  });
  // The initial parameters may be published before the test subscribes.
  for (const Texts& one : come) {
    EXPECT_EQ(one, (Texts{"min-modulation 3: 15", "record 1: false", "strategy 4: PMP"}));
  }
  Texts last;
  for (const Texts& some : changed) last.insert(last.end(), some.begin(), some.end());
  EXPECT_EQ(last, (Texts{"min-modulation 3: 20", "record 1: true", "strategy 4: Gray"}));
}

}  // namespace slipstream::ros2_parameters_test
