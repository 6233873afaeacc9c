#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/page.h"
#include "simulate/accuracy.h"
#include "simulate/artefacts.h"

namespace slipstream {

/// Contents of the report of an acceptance test. Holds references; owns nothing.
struct AccuracyReport {
  const Artefacts& artefacts;
  const Accuracy& accuracy;
  const std::vector<AccuracyFigure>& figures;
  Verdict verdict;
  Facts facts{};   ///< about the run and the scanner, before those of the artefacts
  Facts budget{};  ///< the error of a scan by its sources; may be empty
};

/// Writes report.html and its pictures: the figures with their uncertainties and limits, each
/// sphere and plane, where they stood in the volume, maps of the worst, and a line to sign. Throws
/// WorldError if it cannot be written.
void write_accuracy_report(const std::filesystem::path& folder, const AccuracyReport& report);

}  // namespace slipstream
