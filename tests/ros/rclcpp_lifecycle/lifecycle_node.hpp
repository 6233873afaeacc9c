#pragma once

#include "rclcpp/rclcpp.hpp"
#include "std_srvs/srv/trigger.hpp"

namespace rclcpp_lifecycle {

struct State {};

namespace node_interfaces {
class LifecycleNodeInterface {
 public:
  enum class CallbackReturn : std::uint8_t { SUCCESS, FAILURE, ERROR };
  virtual ~LifecycleNodeInterface() = default;
  virtual CallbackReturn on_configure(const State&) = 0;
  virtual CallbackReturn on_activate(const State&) = 0;
  virtual CallbackReturn on_deactivate(const State&) = 0;
  virtual CallbackReturn on_cleanup(const State&) = 0;
  virtual CallbackReturn on_shutdown(const State&) = 0;
};
}  // namespace node_interfaces

class LifecycleNode : public node_interfaces::LifecycleNodeInterface {
 public:
  LifecycleNode(const std::string&, const rclcpp::NodeOptions& options)
      : parameters_(options.parameters) {}

  template <class Value>
  Value declare_parameter(const std::string& name, const Value& value) {
    return std::get<Value>(parameters_.emplace(name, value).first->second);
  }
  [[nodiscard]] rclcpp::Parameter get_parameter(const std::string& name) const {
    return {parameters_.at(name)};
  }
  [[nodiscard]] rclcpp::Logger get_logger() const { return {}; }
  rclcpp::node_interfaces::NodeTopicsInterface::SharedPtr get_node_topics_interface() {
    return topics;
  }
  template <class Type, class Callback>
  typename rclcpp::Service<Type>::SharedPtr create_service(const std::string& name,
                                                           Callback callback) {
    const auto made = std::make_shared<rclcpp::Service<Type>>();
    made->callback = std::move(callback);
    services[name] = made;
    return made;
  }

  const rclcpp::node_interfaces::NodeTopicsInterface::SharedPtr topics =
      std::make_shared<rclcpp::node_interfaces::NodeTopicsInterface>();
  std::map<std::string, std::weak_ptr<rclcpp::Service<std_srvs::srv::Trigger>>> services{};

 private:
  std::map<std::string, rclcpp::ParameterValue> parameters_;
};

}  // namespace rclcpp_lifecycle
