#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/scan_flags.h"
#include "io/result_files.h"

namespace slipstream::app {

struct ReconstructFlags {
  std::vector<std::string> paths;
  std::optional<std::string> windows;
  std::uint64_t every = 1;
  ScanChanges changes;  ///< how the scans are read
  ScanJobSettings job;  ///< of all scans; a single one may give only maps

  bool one_camera = false;
  int subsample = 1;
  bool normals = false;

  ResultFiles files;
  std::string manifest;  ///< output file; empty: not written
  bool resume = false;

  std::string from;                    ///< one of map_forms: the paths are maps; empty: scans
  std::optional<fs::path> modulation;  ///< with `from`: the map's modulation
  std::vector<ScanName> scans;         ///< outputs requested by the paths
  std::vector<std::string> settings;   ///< Arguments::settings of the command
  const CLI::App* command = nullptr;   ///< the command that owns the flags
};

/// Adds the flags that select scans.
void add_scans_flags(const FlagGroup& command, ReconstructFlags& flags);

/// Adds the flags for reconstruction and outputs.
void add_reconstruct_flags(CLI::App& subcommand, ReconstructFlags& flags);

/// The requested scans: folders, recordings, and .txt lists of them. --windows applies to
/// recordings without their own range. Ranges are cut at the recording's end, which opens the
/// recording unless the list states end and cost; an unreadable recording counts as one scan.
/// Throws Error for an invalid range or one without a window.
std::vector<ListedScans> listed_scans(const ReconstructFlags& flags);

enum class Arguments {
  all,
  settings  ///< arguments that determine the outputs' content, apart from input files
};

/// The flags of add_reconstruct_flags given on the command line or in a rig file, as arguments ("--
/// subsample=2") with absolute paths.
std::vector<std::string> arguments_of(const CLI::App& subcommand, Arguments wanted);

/// Throws Error for impossible values.
void require_valid(const ReconstructFlags& flags);

}  // namespace slipstream::app
