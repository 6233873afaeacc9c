#pragma once

#include <memory>
#include <string>

#include <dds/dds.h>

#include "slipstream/publish/ros_messages.h"

namespace slipstream {

/// What topics of create_message_topic carry: dds_write takes the address of one, dds_take fills
/// one. Nothing of it is copied when it is written.
using SharedMessage = std::shared_ptr<const RosMessage>;

/// Makes the message's length one that DDS sends, a multiple of four.
void pad(RosMessage& message);

/// A topic of messages that are CDR already, of a type that is known by its name alone, as those of
/// ROS 2 are over Cyclone DDS. What is read is short: longer messages are refused. Returns the
/// topic, or a negative error of DDS.
dds_entity_t create_message_topic(dds_entity_t participant, const std::string& name,
                                  const std::string& type);

}  // namespace slipstream
