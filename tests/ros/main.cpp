// Takes the node of ros/ through its life: main RECORDING FOLDER.
#include <chrono>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <thread>

#include "rclcpp_lifecycle/lifecycle_node.hpp"

std::unique_ptr<rclcpp_lifecycle::LifecycleNode> make_node(const rclcpp::NodeOptions& options);

namespace {
using CallbackReturn = rclcpp_lifecycle::LifecycleNode::CallbackReturn;
constexpr rclcpp_lifecycle::State state;

int failures = 0;
void expect(bool right, const std::string& what) {
  if (right) return;
  std::cerr << "not so: " << what << '\n';
  ++failures;
}

std_srvs::srv::Trigger::Response call(rclcpp_lifecycle::LifecycleNode& node,
                                      const std::string& name) {
  const auto response = std::make_shared<std_srvs::srv::Trigger::Response>();
  node.services.at(name).lock()->callback(nullptr, response);
  return *response;
}

int clouds(const rclcpp_lifecycle::LifecycleNode& node) {
  return node.topics->topics.at("~/points")->seen().first;
}

/// The frame in a CDR message's header: 4 bytes, time stamp, length, text.
std::string frame_of(const std::vector<std::uint8_t>& message) {
  return message.size() > 16 ? reinterpret_cast<const char*>(message.data()) + 16 : "";
}

void wait_for_clouds(const rclcpp_lifecycle::LifecycleNode& node, int count) {
  for (int i = 0; i < 30'000 && clouds(node) < count; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

/// Captures a cloud. On a busy machine the first clouds may begin amid the patterns: such clouds
/// are published, but not captured.
std_srvs::srv::Trigger::Response captured(rclcpp_lifecycle::LifecycleNode& node) {
  auto response = call(node, "~/capture");
  for (int i = 0; i < 3'000 && !response.success; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    response = call(node, "~/capture");
  }
  return response;
}

}  // namespace

int main(int, char** arguments) {
  const std::string recording = arguments[1], folder = arguments[2];
  const auto wrong = make_node({{{"source", std::string("replay:nothing.slip")}}});
  expect(wrong->on_configure(state) == CallbackReturn::FAILURE, "a recording that is not there");

  const std::string frame = "left_camera_optical_frame";
  const auto node = make_node({{{"source", "replay:" + recording},
                                {"loop", true},
                                {"frame_id", frame},
                                {"save_to", folder}}});
  for (int round = 0; round < 2; ++round) {
    expect(node->on_configure(state) == CallbackReturn::SUCCESS, "configure");
    expect(!call(*node, "~/capture").success, "nothing to capture yet");
    for (int activations = 0; activations < 2; ++activations) {
      const int before = clouds(*node);
      expect(node->on_activate(state) == CallbackReturn::SUCCESS, "activate");
      wait_for_clouds(*node, before + 3);
      expect(clouds(*node) >= before + 3, "clouds come");
      expect(call(*node, "~/check").success, "OK: no problems found");
      const auto saved = captured(*node);
      expect(saved.success && std::filesystem::exists(saved.message), saved.message);
      expect(node->on_deactivate(state) == CallbackReturn::SUCCESS, "deactivate");
    }
    for (const auto& [name, topic] : node->topics->topics) {
      const auto [count, bytes] = topic->seen();
      expect(count >= 3 && bytes.size() > 100 && bytes[1] == 1, name + " of " + topic->type());
      expect(frame_of(bytes) == frame, name + " is in frame " + frame_of(bytes));
    }
    expect(node->on_cleanup(state) == CallbackReturn::SUCCESS, "clean up");
    expect(node->services.at("~/check").expired(), "services end");
  }
  expect(node->on_shutdown(state) == CallbackReturn::SUCCESS, "shut down");
  return failures;
}
