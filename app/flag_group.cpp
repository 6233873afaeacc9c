#include "app/flag_group.h"

#include <cmath>
#include <cstdlib>

#include "slipstream/io/result_files.h"

namespace slipstream::app {

std::string why_no_number(const std::string& text, bool is_unsigned, bool is_whole) {
  if (text.empty()) return "a number is missing";
  if (is_unsigned && text.find('-') != std::string::npos) return text + " is below 0";
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (*end != '\0') return "'" + text + "' is no number";
  if (!std::isfinite(number)) return text + " is not finite";
  return is_whole && number != std::floor(number) ? text + " is no whole number" : "";
}

void require_distinct_files(const CLI::App& command) {
  constexpr std::string_view replay = "replay:", mcap = "mcap:";
  DistinctFiles files;
  const auto for_each_value = [&](const auto& take) {
    for (const CLI::Option* const option : command.get_options()) {
      for (const std::string& value : option->results()) take(*option, value);
    }
  };
  for_each_value([&](const CLI::Option& option, const std::string& value) {
    if (option.check_name("--scanner")) {
      files.add_scanner(value);
    } else if (option.get_type_name() == file_type) {
      files.add_input(value);
    }
    if (value.starts_with(replay)) files.add_input(value.substr(replay.size()));
  });
  for_each_value([&](const CLI::Option& option, const std::string& value) {
    if (option.get_type_name() == output_type) files.add_output(value);
    if (option.get_type_name() == scanner_output_type) files.add_scanner_output(value);
    if (value.starts_with(mcap)) files.add_output(value.substr(mcap.size()));
  });
}

}  // namespace slipstream::app
