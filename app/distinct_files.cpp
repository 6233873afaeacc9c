#include "app/distinct_files.h"

#include "app/flag_group.h"
#include "slipstream/io/distinct_files.h"

namespace slipstream::app {

void require_distinct_files(const CLI::App& command) {
  constexpr std::string_view replay = "replay:", mcap = "mcap:";
  DistinctFiles files;
  for (const CLI::Option* const option : command.get_options()) {
    for (const std::string& value : option->results()) {
      if (option->check_name("--scanner")) {
        files.add_scanner(value);
      } else if (option->get_type_name() == file_type) {
        files.add_input(value);
      }
      if (value.starts_with(replay)) files.add_input(value.substr(replay.size()));
    }
  }
  for (const CLI::Option* const option : command.get_options()) {
    for (const std::string& value : option->results()) {
      if (option->get_type_name() == output_type) files.add_output(value);
      if (option->get_type_name() == scanner_output_type) files.add_scanner_output(value);
      if (value.starts_with(mcap)) files.add_output(value.substr(mcap.size()));
    }
  }
}

}  // namespace slipstream::app
