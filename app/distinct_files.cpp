#include "app/distinct_files.h"

#include "app/flag_group.h"
#include "slipstream/io/distinct_files.h"

namespace slipstream::app {

void require_distinct_files(const CLI::App& command) {
  constexpr std::string_view replay = "replay:";
  DistinctFiles files;
  for (const CLI::Option* const option : command.get_options()) {
    for (const std::string& value : option->results()) {
      if (option->get_type_name() == file_type) files.add_input(value);
      if (value.starts_with(replay)) files.add_input(value.substr(replay.size()));
    }
  }
  for (const CLI::Option* const option : command.get_options()) {
    if (option->get_type_name() != output_type) continue;
    for (const std::string& value : option->results()) files.add_output(value);
  }
}

}  // namespace slipstream::app
