#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/accuracy/artefacts.h"
#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// How points deviate from a shape of least squares, mm: from that of all but 0.3 % of them, as
/// VDI/VDE 2634 part 2 allows.
struct FormDeviation {
  double range = 0;       ///< the narrowest that holds all but 0.3 % of the deviations
  double dispersion = 0;  ///< the narrowest that holds 95 % of them, as in ISO 10360-13
  double rms = 0;         ///< of all but 0.3 %
  std::size_t points = 0;
};

struct SphereAccuracy {
  double size = 0;  ///< P_S: fitted minus certified diameter, mm
  FormDeviation form;
};

/// One position of a sphere or a ball bar.
struct SpheresAccuracy {
  std::string scan;
  std::vector<SphereAccuracy> spheres;
  std::optional<double> spacing;  ///< S_D: fitted minus certified distance of the centres, mm
};

/// One position of a plane.
struct PlaneAccuracy {
  std::string scan;
  FormDeviation form;
  double bending = 0;  ///< RMS of the deviations' means over 16x16 pixels, where noise is small, mm
};

/// What repeated scans of a thing that stands still say of the same pixels.
struct RepeatAccuracy {
  int scans = 0;
  std::size_t pixels = 0;  ///< with a point in all of them
  double sigma = 0;        ///< the median over them of the standard deviation of Z, mm
};

/// The deviations of the scan in which they are largest, mm; NaN where there is no point.
struct DeviationMap {
  std::string scan;
  Image<double> deviation;
};

/// What an acceptance test finds; a part is empty where no scans of its kind were given.
struct Accuracy {
  std::vector<SpheresAccuracy> spheres;
  std::vector<PlaneAccuracy> planes;
  std::optional<RepeatAccuracy> repeated;
  DeviationMap worst_spheres, worst_plane;
  Image<double> repeat_sigma;  ///< of Z by pixel, mm; NaN where a scan has no point
};

/// A figure as a data sheet states it: that of the worst position, unless `what` says otherwise.
struct AccuracyFigure {
  std::string_view key;  ///< in a JSON document
  std::string_view what;
  double millimetres = 0;
  double share = 0;  ///< of the measured volume's diagonal; NaN where that is not known
};

/// Of all that was measured: probing error of form, its 95 % and of size, sphere spacing, flatness
/// and its 95 %, bending, precision.
std::vector<AccuracyFigure> accuracy_figures(const Accuracy& accuracy, const Artefacts& artefacts);

/// The mean of the spacing errors as a share of the certified distance: 0.001 is 0.1 % too large.
/// None without a ball bar.
std::optional<double> scale_error(const Accuracy& accuracy, const Artefacts& artefacts);

using CloudOfScan = std::function<Cloud(const std::string& scan)>;

/// Finds the artefacts in the scans' clouds, one cloud at a time, and measures them. Of a sphere
/// count the points that the camera sees at up to 60 degrees from the normal, less those within 40
/// degrees of the rod of a ball bar; of a plane, which has to hold two thirds of a cloud's points,
/// those nearer to it than 1 % of its length. Throws Error, naming the scan, where an artefact is
/// not found, or repeated scans are one and the same.
Accuracy measure_accuracy(const Artefacts& artefacts, const CloudOfScan& cloud_of);

}  // namespace slipstream
