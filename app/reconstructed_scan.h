#pragma once

#include "app/reconstruct_flags.h"
#include "slipstream/reconstruct/epipolar.h"

namespace slipstream::app {

/// One scan's results, ready to print.
struct ReconstructedScan {
  ScanName name;
  std::string failure;  ///< reason if it failed, or empty
  Output words{false};  ///< its lines, held until its turn
  Cloud cloud;
  ValidityCounts counts{};
  Maps maps;  ///< if requested
  Wanted wanted = Wanted::points;
  std::optional<Uncertainty> uncertainty;
  std::optional<EpipolarCheck> epipolar;  ///< both axes only
  std::string backend;
  std::vector<std::string> warnings;
  SoundScan sound;
  ResultFiles files;                                   ///< files written
  std::optional<double> rms, predicted, median_sigma;  ///< mm
  double least_modulation = 0;  ///< minimum modulation of a point, grey levels of 255
  double read = 0, tables = 0, computed = 0, written = 0;  ///< s
  bool done_before = false;  ///< done by an earlier run; prints nothing else
  nlohmann::json entry;      ///< its manifest entry
};

/// Its part of the JSON document.
nlohmann::json document_of(const ReconstructedScan& scan);

/// Its line of the manifest.
std::string line_of(const ReconstructedScan& scan);

/// Prints its lines.
void tell(const ReconstructedScan& scan, Output& output);

}  // namespace slipstream::app
