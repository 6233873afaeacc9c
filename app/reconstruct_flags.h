#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "app/cloud_input.h"
#include "app/flag_group.h"
#include "app/output.h"
#include "slipstream/io/result_files.h"
#include "slipstream/reconstruct/phase_matcher.h"

namespace slipstream::app {

struct ReconstructFlags {
  std::vector<std::string> paths;
  std::optional<std::string> windows;
  std::uint64_t every = 1;
  CloudInputFlags cloud;
  std::string backend = "fused";
  std::string unwrapping = "consensus";
  bool one_camera = false;
  PhaseMatchSettings match;
  int subsample = 1;
  bool normals = false;
  bool uncertainty = false;
  ResultFiles files;
  std::string manifest;  ///< file; none where empty
  bool resume = false;
  std::vector<ScanName> scans;        ///< of the paths, what is asked for
  std::vector<std::string> settings;  ///< Arguments::settings of the command
  const CLI::App* command = nullptr;  ///< whose flags they are
};

/// Adds those that say which scans.
void add_scans_flags(const FlagGroup& command, ReconstructFlags& flags);

/// Adds those that say how they are reconstructed, and what is written where.
void add_reconstruct_flags(CLI::App& subcommand, ReconstructFlags& flags);

enum class Arguments {
  all,
  settings  ///< that decide what outputs hold, beside files that are read
};
/// Of its flags those of add_reconstruct_flags that were given, also by a rig file, as arguments:
/// "--subsample=2", with paths that are absolute.
std::vector<std::string> arguments_of(const CLI::App& subcommand, Arguments wanted);

/// Puts what they say where `cloud` has its settings. Throws Error for values that are none.
void apply_settings(ReconstructFlags& flags);

/// Reconstructs `scans` and tells each. Throws Error for flags that do not fit together.
void reconstruct_scans(ReconstructFlags flags, Output& output);

}  // namespace slipstream::app
