#include "app/batch_plan.h"

#include <string>

#include <nlohmann/json.hpp>

#include "base/throw_if-inl.h"

namespace slipstream::app {

BatchPlan batch_plan_from(const std::string& text, const std::string& name) try {
  const nlohmann::json json = nlohmann::json::parse(text);
  throw_if(json.at("version") != SLIPSTREAM_VERSION,
           "{}: planned by version {}, but this program is version {}; run slipstream batch plan "
           "again",
           name, json.at("version").dump().substr(0, 40), SLIPSTREAM_VERSION);

  return {.tasks = json.at("tasks").get<std::uint64_t>(),
          .arguments = json.at("arguments").get<std::vector<std::string>>()};
} catch (const nlohmann::json::exception&) {
  throw Error(fmt::format("{}: not a plan of slipstream batch", name));
}

}  // namespace slipstream::app
