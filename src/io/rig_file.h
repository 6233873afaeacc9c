#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slipstream {

/// One setting of a rig file, which has the settings common to all scans of a rig: a YAML map of
/// settings by name, optionally grouped under headings.
///
///   camera:
///     source: v4l2:0
///     exposure: 8
///   scanner: scanner.yaml
struct RigSetting {
  std::string name{};                 ///< "low-steps", even if written low_steps
  std::vector<std::string> values{};  ///< as written; one value, or a list's
  int line = 0;                       ///< line number, from 1
};

/// The settings of a rig file in order. Throws Error with file and line if it is not such a map, if
/// a value is neither a text nor a list of texts, or for a duplicate name.
std::vector<RigSetting> read_rig(const std::filesystem::path& file);

/// The same for a file's text; `name`: the file's name in messages.
std::vector<RigSetting> rig_from(const std::string& text, const std::string& name);

}  // namespace slipstream
