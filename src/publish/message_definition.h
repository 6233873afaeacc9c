#pragma once

#include <string>
#include <string_view>

#include <fmt/format.h>

// Parts of the "ros2msg" texts that define message types.
namespace slipstream {

/// The definition of a type used by another.
inline std::string named_definition(std::string_view name, std::string_view fields) {
  return fmt::format("\n{:=>80}\nMSG: {}\n{}", "", name, fields);
}

/// The definition of std_msgs/Header with its time.
inline std::string header_definition() {
  return named_definition("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n") +
         named_definition("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
}

}  // namespace slipstream
