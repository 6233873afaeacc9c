#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "slipstream/simulate/accuracy.h"

namespace slipstream {

/// Writes report.md and its pictures into a folder: the figures in mm and per mille of the measured
/// volume's diagonal (mm), each sphere and plane, and maps of what deviates most. `subject` says in
/// a line what was measured. Throws WorldError where it cannot be written.
void write_accuracy_report(const std::filesystem::path& folder, const std::string& subject,
                           const Accuracy& accuracy, std::optional<double> diagonal);

}  // namespace slipstream
