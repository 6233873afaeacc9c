#pragma once

#include <dds/dds.h>

#include "slipstream/publish/ros_messages.h"

namespace slipstream {

/// What topics carry: dds_write takes the address of one, without a copy, and dds_take fills one.
using SharedMessage = std::shared_ptr<const RosMessage>;

/// Makes the message's length one that DDS sends, a multiple of four.
void pad(RosMessage& message);

/// A topic of messages that are CDR already, of a type known by its name alone, as in ROS 2 over
/// Cyclone DDS. Refuses to read long messages. Returns the topic, or a negative error of DDS.
dds_entity_t create_message_topic(dds_entity_t participant, const std::string& name,
                                  const std::string& type);

}  // namespace slipstream
