#include "app/output.h"

#include <string>

#include "slipstream/error/error.h"

namespace slipstream::app {

void Output::warn(std::string_view message) {
  write_line(stderr, fmt::format("warning: {}", message));
}

void Output::finish() {
  if (json_) {  // names of files need not be UTF-8
    write_line(stdout, document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  if (std::fflush(stdout) != 0) throw WorldError("cannot write to standard output");
}

void Output::write_line(std::FILE* stream, std::string_view line) {
  fmt::print(stream, "{}\n", line);
}

}  // namespace slipstream::app
