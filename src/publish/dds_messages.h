#pragma once

#include <memory>
#include <string>

#include <dds/dds.h>

#include "slipstream/ros_messages.h"

namespace slipstream {

/// A topic's sample: dds_write takes its address, without a copy, and dds_take fills one.
using SharedMessage = std::shared_ptr<const RosMessage>;

/// Pads the message to a multiple of four bytes, as DDS requires.
void pad(RosMessage& message);

/// Creates a topic of ready-made CDR messages of a type known only by name, as in ROS 2 over
/// Cyclone DDS. Rejects long messages when reading. Returns the topic, or a negative DDS error.
dds_entity_t create_message_topic(dds_entity_t participant, const std::string& name,
                                  const std::string& type);

}  // namespace slipstream
