#pragma once

#include <memory>

#include "rclcpp_lifecycle/lifecycle_node.hpp"

#define RCLCPP_COMPONENTS_REGISTER_NODE(Node)                                                      \
  std::unique_ptr<rclcpp_lifecycle::LifecycleNode> make_node(const rclcpp::NodeOptions& options) { \
    return std::make_unique<Node>(options);                                                        \
  }
