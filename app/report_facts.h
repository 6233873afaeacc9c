#pragma once

#include <filesystem>
#include <string>

#include "app/output.h"
#include "base/page.h"

namespace slipstream {
struct ErrorBudget;
struct Scanner;
}  // namespace slipstream

namespace slipstream::app {

/// The facts of a run for its report: date, program version and command.
Facts facts_of_run(const Output& output);

/// Adds the scanner's file with size and CRC-32, if it is one, the sizes of its pictures, and how
/// it was calibrated.
void add_scanner(Facts& facts, const Scanner& scanner, const std::filesystem::path& file);

/// Adds the temperature of a part of the camera, degrees Celsius: from its first or least to its
/// last or largest.
void add_temperature(Facts& facts, const std::string& part, double from, double to);

/// An error budget, a row for each source and the total: its size, a bar and how it was found.
Facts facts_of(const ErrorBudget& budget);

/// In JSON: `total_mm`, and `sources` with `source`, `mm` and `found`.
nlohmann::json json_of(const ErrorBudget& budget);

}  // namespace slipstream::app
