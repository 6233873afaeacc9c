#pragma once

#include <set>
#include <string>

#include <yaml-cpp/node/node.h>

#include "slipstream/error.h"

namespace slipstream {

/// A file contains two values for one key and would ignore one.
struct RepeatedKey : Error {
  using Error::Error;
};

/// Throws RepeatedKey, "line N: KEY is set twice", if `keys` has the key; otherwise adds it.
void add_key(std::set<std::string>& keys, const std::string& key, std::ptrdiff_t line);

/// The only document of a YAML text. Throws Error with the line, RepeatedKey if any of its maps
/// repeats a key or another document follows; also if the text is not YAML or expands by aliases to
/// more values than it has bytes.
YAML::Node yaml_document(const std::string& text);

}  // namespace slipstream
