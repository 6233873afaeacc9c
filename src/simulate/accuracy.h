#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/page.h"
#include "slipstream/engine.h"
#include "slipstream/virtual_world.h"

namespace slipstream {

/// Input of an acceptance test: certified artefacts and scans of them. In a file, a YAML map with
/// these names, lengths in mm, paths relative to the file:
///
///   diameters: [40.002, 40.001]   # of the sphere, or of both of a ball bar
///   distance: 100.005             # of the ball bar's centres
///   spheres: [bar1, bar2]         # a scan of all spheres in each position
///   planes: [plane1, plane2]      # a scan of the plane in each position
///   repeated: [still1, still2]    # of one static object, with nothing changed between them
///   diagonal: 380                 # of the measured volume
struct Artefacts {
  std::vector<double> diameters{};   ///< mm; up to two
  std::optional<double> distance{};  ///< mm; of two spheres
  std::vector<std::string> spheres{}, planes{}, repeated{};
  std::optional<double> diagonal{};  ///< mm; if set, figures are also given relative to it
};

/// Throws Error with file and line if the file is not such a map.
Artefacts read_artefacts(const std::filesystem::path& file);

/// Deviations of a sphere's or a plane's points from the least-squares shape, mm, without the 0.3 %
/// that VDI/VDE 2634 part 2 allows to exclude.
struct ShapeAccuracy {
  std::string scan;
  double range = 0;     ///< narrowest range with 99.7 % of the deviations
  double range_95 = 0;  ///< narrowest range with 95 % of them, as in ISO 10360-13
  double rms = 0;       ///< of 99.7 %
  std::size_t points = 0;
  Image<double> deviation;          ///< the part of the picture with the shape; NaN elsewhere
  std::optional<double> size{};     ///< of a sphere: fitted minus certified diameter
  std::optional<double> spacing{};  ///< of a ball bar's second: fitted minus certified distance
  std::optional<double> bending{};  ///< of a plane: RMS of the deviations' means over 16x16 pixels
};

/// Result of repeated scans of a static object.
struct Repeatability {
  int scans = 0;
  Image<double> sigma;  ///< standard deviation of Z, mm; NaN if a scan lacks the point
};

/// Result of an acceptance test.
struct Accuracy {
  std::vector<ShapeAccuracy> shapes;  ///< spheres, then planes, in the order of their scans
  std::optional<Repeatability> repeated;
};

/// A figure as a data sheet states it, mm.
struct AccuracyFigure {
  std::string_view key;  ///< in JSON
  std::string_view what;
  double value = 0;
};

/// All measured figures, for the worst position unless `what` says otherwise.
std::vector<AccuracyFigure> accuracy_figures(const Accuracy& accuracy);

/// Compares the worst systematic error (size, spacing, planarity) with the points' random
/// deviations there: "good" if it is smaller, "bad" above three times, and what to do.
Verdict verdict_of(const Accuracy& accuracy);

using CloudOfScan = std::function<Cloud(const std::string& scan)>;

/// Finds the artefacts in the scans' clouds, one cloud at a time, and measures them. Spheres: uses
/// points seen at up to 60 degrees from the normal, but not within 40 degrees of a ball bar's rod.
/// Planes, which must have two thirds of a cloud's points: uses one connected piece of points
/// nearer than 1 % of the plane's length (2.5 times the median distance of its points from their
/// centre), without a rim of 5 pixels, where blur moves points. Throws Error with the scan's name
/// if an artefact is not found or repeated scans are copies.
Accuracy measure_accuracy(const Artefacts& artefacts, const CloudOfScan& cloud_of);

/// Writes report.html and its pictures: the figures in mm and per mille of the measured volume's
/// diagonal (mm), each sphere and plane, and maps of the worst. `subject`: one line that describes
/// the test. Throws WorldError if it cannot be written.
void write_accuracy_report(const std::filesystem::path& folder, const std::string& subject,
                           const Accuracy& accuracy, std::optional<double> diagonal);

}  // namespace slipstream
