#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/simulate/artefacts.h"

namespace slipstream {

/// A sphere or a plane in one position: how its points deviate from the shape of least squares of
/// all but 0.3 % of them, which VDI/VDE 2634 part 2 allows to leave out; mm.
struct ShapeAccuracy {
  std::string scan;
  double range = 0;     ///< the narrowest that holds all but 0.3 % of the deviations
  double range_95 = 0;  ///< the narrowest that holds 95 % of them, as ISO 10360-13 has it
  double rms = 0;       ///< of all but 0.3 %
  std::size_t points = 0;
  Image<double> deviation;          ///< the part of the picture with the shape; NaN elsewhere
  std::optional<double> size{};     ///< of a sphere: fitted minus certified diameter
  std::optional<double> spacing{};  ///< of a ball bar's second: fitted minus certified distance
  std::optional<double> bending{};  ///< of a plane: RMS of the deviations' means over 16x16 pixels
};

/// What repeated scans of a thing that stands still say.
struct Repeatability {
  int scans = 0;
  Image<double> sigma;  ///< standard deviation of Z, mm; NaN where a scan has no point
};

/// What an acceptance test finds.
struct Accuracy {
  std::vector<ShapeAccuracy> shapes;  ///< spheres, then planes, in the order of their scans
  std::optional<Repeatability> repeated;
};

/// A figure as a data sheet states it, mm.
struct AccuracyFigure {
  std::string_view key;  ///< in a JSON document
  std::string_view what;
  double value = 0;
};

/// Those of all that was measured, of the worst position where `what` does not say otherwise.
std::vector<AccuracyFigure> accuracy_figures(const Accuracy& accuracy);

using CloudOfScan = std::function<Cloud(const std::string& scan)>;

/// Finds the artefacts in the scans' clouds, one cloud at a time, and measures them. Of a sphere
/// count the points that the camera sees at up to 60 degrees from the normal, less those within 40
/// degrees of the rod of a ball bar. Of a plane, which has to hold two thirds of a cloud's points,
/// count those nearer to it than 1 % of its length (2.5 times the median distance of its points
/// from their middle) in one piece, less a rim of 5 pixels, where blur moves what is seen. Throws
/// Error, naming the scan, where an artefact is not found, or where repeated scans are copies.
Accuracy measure_accuracy(const Artefacts& artefacts, const CloudOfScan& cloud_of);

}  // namespace slipstream
