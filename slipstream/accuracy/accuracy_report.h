#pragma once

#include <filesystem>
#include <string>

#include "slipstream/accuracy/accuracy.h"

namespace slipstream {

/// Writes one page of HTML with its pictures in it: the figures in mm and per mille of the measured
/// volume's diagonal, each position, and maps of the deviations where they are largest. `subject`
/// says in a line what was measured. Throws Error for another ending than .html, WorldError where
/// it cannot be written.
void write_accuracy_report(const std::filesystem::path& path, const std::string& subject,
                           const Accuracy& accuracy, const Artefacts& artefacts);

}  // namespace slipstream
