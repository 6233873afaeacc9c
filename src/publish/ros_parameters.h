#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "publish/cdr.h"
#include "slipstream/cloud_sink.h"

namespace slipstream {

struct RosService {
  std::string name;  ///< "scanner/capture"
  std::string type;  ///< "std_srvs/srv/Trigger"
  /// Reads the request and appends the answer. Throws Error for an invalid request.
  std::function<void(CdrReader& request, Cdr& answer)> answer;
};

/// Appends a Trigger or SetParametersResult: true and the result of `work`, or false and its error.
template <class Work>
void add_outcome(Cdr& answer, const Work& work) {
  std::string text;
  bool success = false;

  try {
    text = work();
    success = true;
  } catch (const std::exception& error) {
    text = error.what();
  }

  answer.add(static_cast<std::uint8_t>(success)).add_text(text);
}

/// The services by which ROS 2 reads and changes a node's parameters: the settings of the borrowed
/// run. Numbers are doubles (integers are accepted), switches booleans, everything else text.
std::vector<RosService> parameter_services(const std::string& node, const PublishedRun& run);

/// rcl_interfaces/msg/ParameterEvent: new, changed and removed settings. Returns false if there are
/// none.
bool write_parameter_event(const std::string& node, std::uint64_t time,
                           const std::vector<RunSetting>& before,
                           const std::vector<RunSetting>& now, RosMessage& message);

}  // namespace slipstream
