// Stands in for ros2_sink.cpp where Cyclone DDS is not installed.
#include "slipstream/base/error.h"
#include "slipstream/publish/named_sink.h"

namespace slipstream {

const SinkKind ros2_sink{
    "ros2", "ros2:NAMESPACE",
    [](const std::string& name) {
      throw Error("--publish ros2:" + name +
                  " needs Cyclone DDS, without which this program was built (cyclonedds-dev, "
                  "-DSLIPSTREAM_ROS2=ON)");
    },
    [](const std::string&, PublishedRun) { return std::unique_ptr<CloudSink>(); }};

}  // namespace slipstream
