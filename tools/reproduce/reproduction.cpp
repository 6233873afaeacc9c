#include "tools/reproduce/reproduction.h"

#include <algorithm>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "tools/reproduce/multiplexing.h"

namespace slipstream {

std::vector<Reproducible> reproducibles() {
  std::vector<Reproducible> all;
  for (const auto& some : {multiplexing_table_reproducibles(), noise_figure_reproducibles(),
                           gamma_reproducibles(), motion_reproducibles(), model_reproducibles()}) {
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

std::vector<Reproducible> reproducibles_named(const std::vector<std::string>& names) {
  std::vector<Reproducible> all = reproducibles();
  if (names.empty() || std::find(names.begin(), names.end(), "all") != names.end()) return all;
  const auto means = [](const std::string& name, const Reproducible& item) {
    return name.ends_with('.') ? item.name().starts_with(name) : item.name() == name;
  };
  for (const std::string& name : names) {
    const bool known = std::any_of(all.begin(), all.end(),
                                   [&](const Reproducible& item) { return means(name, item); });
    if (!known) {
      std::vector<std::string> possible;
      for (const Reproducible& item : all) possible.push_back(item.name());
      throw Error(fmt::format("'{}' is not known; it is all or some of: {}", name,
                              fmt::join(possible, ", ")));
    }
  }
  std::erase_if(all, [&](const Reproducible& item) {
    return std::none_of(names.begin(), names.end(),
                        [&](const std::string& name) { return means(name, item); });
  });
  return all;
}

}  // namespace slipstream
