// As much of ROS 2 as ros/ uses, so that it is compiled and runs where ROS 2 is not to be had. It
// is no client library: topics keep what they were given, services are called by name.
#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <variant>
#include <vector>

struct rcl_serialized_message_t {
  std::uint8_t* buffer;
  std::size_t buffer_length;
};

namespace rclcpp {

struct Logger {};
struct QoS {};
struct SensorDataQoS : QoS {};

using ParameterValue = std::variant<bool, double, std::string>;
struct NodeOptions {
  std::map<std::string, ParameterValue> parameters{};
};
struct Parameter {
  ParameterValue value;
  [[nodiscard]] bool as_bool() const { return std::get<bool>(value); }
  [[nodiscard]] double as_double() const { return std::get<double>(value); }
  [[nodiscard]] std::string as_string() const { return std::get<std::string>(value); }
};

class SerializedMessage {
 public:
  explicit SerializedMessage(std::size_t capacity) : bytes_(capacity), message_{bytes_.data(), 0} {}
  rcl_serialized_message_t& get_rcl_serialized_message() { return message_; }
  [[nodiscard]] const rcl_serialized_message_t& get_rcl_serialized_message() const {
    return message_;
  }

 private:
  std::vector<std::uint8_t> bytes_;
  rcl_serialized_message_t message_;
};

class GenericPublisher {
 public:
  using SharedPtr = std::shared_ptr<GenericPublisher>;
  explicit GenericPublisher(std::string type) : type_(std::move(type)) {}
  [[nodiscard]] std::size_t get_subscription_count() const { return 1; }
  void publish(const SerializedMessage& message) {
    const rcl_serialized_message_t& raw = message.get_rcl_serialized_message();
    const std::lock_guard lock(mutex_);
    ++count_;
    last_.assign(raw.buffer, raw.buffer + raw.buffer_length);
  }
  [[nodiscard]] const std::string& type() const { return type_; }
  [[nodiscard]] std::pair<int, std::vector<std::uint8_t>> seen() const {
    const std::lock_guard lock(mutex_);
    return {count_, last_};
  }

 private:
  const std::string type_;
  mutable std::mutex mutex_;
  int count_ = 0;
  std::vector<std::uint8_t> last_;
};

namespace node_interfaces {
struct NodeTopicsInterface {
  using SharedPtr = std::shared_ptr<NodeTopicsInterface>;
  std::map<std::string, GenericPublisher::SharedPtr> topics{};
};
}  // namespace node_interfaces

inline GenericPublisher::SharedPtr create_generic_publisher(
    const node_interfaces::NodeTopicsInterface::SharedPtr& topics, const std::string& name,
    const std::string& type, const QoS&) {
  return topics->topics[name] = std::make_shared<GenericPublisher>(type);
}

template <class Type>
struct Service {
  using SharedPtr = std::shared_ptr<Service>;
  std::function<void(std::shared_ptr<typename Type::Request>,
                     std::shared_ptr<typename Type::Response>)>
      callback{};
};

}  // namespace rclcpp

#define RCLCPP_ERROR(logger, ...) ((void)(logger), std::fprintf(stderr, __VA_ARGS__))
#define RCLCPP_WARN(logger, ...) RCLCPP_ERROR(logger, __VA_ARGS__)
