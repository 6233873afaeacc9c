#pragma once

#include "publish/sink_kind.h"

namespace slipstream {

/// Publishes clouds, pictures and services to ROS 2 over Cyclone DDS, in the domain ROS_DOMAIN_ID.
extern const SinkKind ros2_sink;

}  // namespace slipstream
