#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slipstream {

/// One setting of a rig file, which holds what is the same for all scans of one rig: a YAML map of
/// settings by name, in any headings, each a name over a map of its settings.
///
///   camera:
///     source: v4l2:0
///     exposure: 8
///   scanner: scanner.yaml
struct RigSetting {
  std::string name{};                 ///< "low-steps", also where it is written low_steps
  std::vector<std::string> values{};  ///< as written; one, or those of a list
  int line = 0;                       ///< where it stands, from 1
};

/// The settings of a rig file in their order. Throws Error, naming the file and the line, where it
/// is no such map, a value is neither a text nor a list of texts, or a name comes twice.
std::vector<RigSetting> read_rig(const std::filesystem::path& file);

/// The same of such a file's text; `name` is what a message calls it.
std::vector<RigSetting> rig_from(const std::string& text, const std::string& name);

}  // namespace slipstream
