#pragma once

#include <functional>
#include <string>
#include <vector>

#include "slipstream/publish/cdr.h"
#include "slipstream/publish/cloud_sink.h"

namespace slipstream {

/// A service of ROS 2.
struct RosService {
  std::string name;  ///< "scanner/capture"
  std::string type;  ///< "std_srvs/srv/Trigger"
  /// Reads what is asked and adds the answer. Throws Error where the request is none.
  std::function<void(CdrReader& request, Cdr& answer)> answer;
};

/// The services by which ROS 2 reads and changes the parameters of the node of that name: the
/// settings of the run, which is borrowed. Numbers are doubles (whole numbers are taken too),
/// switches booleans, all else texts.
std::vector<RosService> parameter_services(const std::string& node, const PublishedRun& run);

/// rcl_interfaces/msg/ParameterEvent: which settings have come, changed and gone. False where that
/// is none.
bool write_parameter_event(const std::string& node, std::uint64_t time,
                           const std::vector<RunSetting>& before,
                           const std::vector<RunSetting>& now, RosMessage& message);

}  // namespace slipstream
