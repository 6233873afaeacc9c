#include "app/report_facts.h"

#include <chrono>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <string>

#include <fmt/chrono.h>

#include "io/file.h"
#include "slipstream/scan_job.h"
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

void add_temperature(Facts& facts, const std::string& part, double from, double to) {
  const std::string range = from == to ? "" : fmt::format(" to {:g}", to);
  facts.emplace_back("temperature of the camera, " + part,
                     fmt::format("{:g}{} degrees Celsius", from, range));
}

Facts facts_of(const ErrorBudget& budget) {
  constexpr int longest = 20;  // letters of a bar
  const double total = budget.total();

  const auto row = [&](double depth, const std::string& found) {
    const double share = total > 0 ? depth / total : 0;
    const std::string bar(static_cast<std::size_t>(std::lround(longest * share)), '#');
    return fmt::format("{:.4f} mm {:{}} {}", depth, bar, longest, found);
  };

  Facts facts;
  for (const auto& [name, depth, found] : budget.sources) {
    facts.emplace_back(name, depth ? row(*depth, found) : "unknown: " + found);
  }
  facts.emplace_back("total", row(total, "root of the sum of squares"));
  return facts;
}

nlohmann::json json_of(const ErrorBudget& budget) {
  const auto sources = as_json(budget.sources, [](const ErrorSource& source) {
    return described("source", source.name, "mm", source.depth, "found", source.found);
  });
  return described("total_mm", budget.total(), "sources", sources);
}

}  // namespace slipstream::app
