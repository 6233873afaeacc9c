#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace slipstream {

/// What an acceptance test looks at: artefacts as certified, and scans of them. In a file a YAML
/// map of these names, lengths in mm, paths relative to the file:
///
///   diameters: [40.002, 40.001]   # of the sphere, or of both of a ball bar
///   distance: 100.005             # of the ball bar's centres
///   spheres: [bar1, bar2]         # a scan of all spheres in each position
///   planes: [plane1, plane2]      # a scan of the plane in each position
///   repeated: [still1, still2]    # of one thing that stands still, nothing changed between them
///   diagonal: 380                 # of the measured volume
struct Artefacts {
  std::vector<double> diameters{};   ///< mm; none, one or two
  std::optional<double> distance{};  ///< mm; of two spheres
  std::vector<std::string> spheres{};
  std::vector<std::string> planes{};
  std::vector<std::string> repeated{};
  std::optional<double> diagonal{};  ///< mm; where figures are to be stated as shares of it
};

/// Throws Error, naming the file and the line, for a file that is no such map.
Artefacts read_artefacts(const std::filesystem::path& file);

}  // namespace slipstream
