#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace slipstream::app {

/// Contents of a batch.json: the number of shards, and the arguments of every run.
struct BatchPlan {
  std::uint64_t tasks = 0;
  std::vector<std::string> arguments{};
};

/// Parses the text of the file `name`. Throws Error with it for a plan of another version, which
/// may reconstruct differently, or if it is none.
BatchPlan batch_plan_from(const std::string& text, const std::string& name);

}  // namespace slipstream::app
