#pragma once

#include <optional>
#include <vector>

#include <CLI/App.hpp>

#include "app/output.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream::app {

/// The flags that say which points of a cloud are left out and what else is done to it.
struct CleanFlags {
  bool raw = false;
  std::optional<double> largest_sigma;
  std::optional<int> smallest_component;
  std::vector<double> box, outline;
  int widest_gap = 0;
  int smoothing = 0;
};

/// Adds --raw, --max-sigma, --min-component, --box, --outline, --fill and --smooth.
void add_clean_flags(CLI::App& subcommand, CleanFlags& flags);

/// Sets what they say; --raw takes the limits of depth away, but those asked for. Throws Error
/// where that is no box or outline, or out of range.
void set_clean(ReconstructSettings& settings, const CleanFlags& flags);

/// By the names of the reasons.
nlohmann::json json_of(const ValidityCounts& counts);

}  // namespace slipstream::app
