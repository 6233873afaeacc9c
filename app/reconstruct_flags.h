#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "app/commands.h"
#include "app/output.h"
#include "app/scan_flags.h"
#include "slipstream/io/result_files.h"
#include "slipstream/reconstruct/phase_matcher.h"

namespace slipstream::app {

struct ReconstructFlags {
  std::vector<std::string> paths;
  std::optional<std::string> windows;
  std::uint64_t every = 1;
  CloudFlags cloud;
  bool one_camera = false;
  PhaseMatchSettings match;
  int subsample = 1;
  bool normals = false;
  bool uncertainty = false;
  ResultFiles files;
  std::string manifest;  ///< file; none if empty
  bool resume = false;
  std::vector<ScanName> scans;        ///< of the paths, what is asked for
  std::vector<std::string> settings;  ///< Arguments::settings of the command
  const CLI::App* command = nullptr;  ///< whose flags they are
};

/// Adds those that say which scans.
void add_scans_flags(const FlagGroup& command, ReconstructFlags& flags);

/// Adds those that say how they are reconstructed, and what is written where.
void add_reconstruct_flags(CLI::App& subcommand, ReconstructFlags& flags);

/// The scans that are asked for: folders, recordings, and lists of them, whose names end in .txt.
/// --windows is the range of recordings without one of their own. A range ends at the end of its
/// recording, which is opened for that unless the list says end and cost; one that cannot be read
/// is one scan. Throws Error for a range that is none or has no window.
std::vector<ListedScans> listed_scans(const ReconstructFlags& flags);

enum class Arguments {
  all,
  settings  ///< that decide what outputs hold, beside files that are read
};
/// Of its flags those of add_reconstruct_flags that were given, also by a rig file, as arguments:
/// "--subsample=2", with absolute paths.
std::vector<std::string> arguments_of(const CLI::App& subcommand, Arguments wanted);

/// Throws Error for values that cannot be.
void require_valid(const ReconstructFlags& flags);

/// Reconstructs `scans` and tells each. Throws Error for flags that do not fit together.
void reconstruct_scans(ReconstructFlags flags, Output& output);

}  // namespace slipstream::app
