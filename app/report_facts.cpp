#include "app/report_facts.h"

#include <chrono>
#include <ctime>
#include <string>

#include <fmt/chrono.h>

#include "io/file.h"
#include "slipstream/scanner.h"

namespace slipstream::app {
namespace fs = std::filesystem;

Facts facts_of_run(const Output& output) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());

  return {{"date", fmt::format("{:%Y-%m-%d %H:%M %Z}", fmt::localtime(now))},
          {"program", "slipstream " + output.run.version},
          {"command", output.run.command}};
}

void add_scanner(Facts& facts, const Scanner& scanner, const fs::path& file) {
  if (fs::is_regular_file(file)) {
    facts.emplace_back("scanner file", fmt::format("{}, {} bytes, CRC-32 {:08x}", file.string(),
                                                   fs::file_size(file), checksum_of_file(file)));
  }

  facts.emplace_back("pictures",
                     fmt::format("camera {}, projector {}", text_of(scanner.camera.size),
                                 text_of(scanner.projector.size)));
  if (!scanner.measured.empty()) facts.emplace_back("calibrated", scanner.measured);
  if (scanner.calibration_rms > 0) {
    facts.emplace_back("reprojection error", fmt::format("{:.3f} px", scanner.calibration_rms));
  }
}

}  // namespace slipstream::app
