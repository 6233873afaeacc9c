#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace slipstream {

/// Input of an acceptance test: certified artefacts and scans of them. In a file, a YAML map with
/// these names, lengths in mm, paths relative to the file:
///
///   diameters: [40.002, 40.001]   # of the sphere, or of both of a ball bar
///   distance: 100.005             # of the ball bar's centres
///   diameter-uncertainty: 0.0006  # expanded (k = 2), as certified
///   distance-uncertainty: 0.0008
///   spheres: [bar1, bar2]         # a scan of all spheres in each position
///   planes: [plane1, plane2]      # a scan of the plane in each position
///   repeated: [still1, still2]    # of one static object, with nothing changed between them
///   diagonal: 380                 # of the measured volume
///   temperature: 20.4             # of the room, degrees Celsius
///   notes: [ball bar 7 with certificate 1234, camera no. 40, lens 12 mm]   # lines of the report
struct Artefacts {
  std::vector<double> diameters{};   ///< mm; up to two
  std::optional<double> distance{};  ///< mm; of two spheres
  /// mm; expanded uncertainty, with a coverage factor of 2.
  std::optional<double> diameter_uncertainty{}, distance_uncertainty{};
  std::vector<std::string> spheres{}, planes{}, repeated{};
  std::optional<double> diagonal{};     ///< mm; if set, figures are also given relative to it
  std::optional<double> temperature{};  ///< degrees Celsius
  std::vector<std::string> notes{};     ///< about artefacts and devices, for the report
};

/// Throws Error with file and line if the file is not such a map.
Artefacts read_artefacts(const std::filesystem::path& file);

}  // namespace slipstream
