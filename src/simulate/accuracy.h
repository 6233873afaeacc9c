#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "base/page.h"
#include "simulate/artefacts.h"
#include "slipstream/engine.h"

namespace slipstream {

/// A measured value and its standard uncertainty, mm. The uncertainty counts the scatter of the
/// points, taken as independent, and the certified value.
struct Estimate {
  double value = 0;
  double uncertainty = 0;
};

/// Deviations of a sphere's or a plane's points from the least-squares shape, mm, without the 0.3 %
/// that VDI/VDE 2634 part 2 allows to exclude.
struct ShapeAccuracy {
  std::string scan;
  Estimate range;     ///< narrowest range with 99.7 % of the deviations
  Estimate range_95;  ///< narrowest range with 95 % of them, as in ISO 10360-13
  double rms = 0;     ///< of 99.7 %
  std::size_t points = 0;
  Image<double> deviation;            ///< the part of the picture with the shape; NaN elsewhere
  Eigen::AlignedBox3d extent{};       ///< of the points, in the camera's frame
  std::optional<Estimate> size{};     ///< of a sphere: fitted minus certified diameter
  std::optional<Estimate> spacing{};  ///< of a ball bar's second: fitted minus certified distance
  std::optional<Estimate>
      bending{};  ///< of a plane: RMS of the deviations' means over 16x16 pixels
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
  std::string_view standard;  ///< name of the figure in VDI/VDE 2634 part 2 or ISO 10360-13, or ""
  Estimate measured{};
  std::optional<double> limit{};  ///< largest allowed absolute value

  /// Whether it exceeds its limit.
  [[nodiscard]] bool fails() const { return limit && std::abs(measured.value) > *limit; }
};

/// All measured figures, for the worst position unless `what` says otherwise.
std::vector<AccuracyFigure> accuracy_figures(const Accuracy& accuracy);

/// The keys of all figures.
std::vector<std::string> accuracy_keys();

/// Sets the limits, by the figures' keys, mm. Throws Error for a limit of a figure that was not
/// measured.
void set_limits(std::vector<AccuracyFigure>& figures,
                const std::vector<std::pair<std::string, double>>& limits);

/// Compares the figures with their limits; without limits, the worst systematic error (size,
/// spacing, planarity) with the points' random deviations there: "good" if it is smaller, "bad"
/// above three times, and what to do. `exact_scanner`: the virtual world's own scanner was used, so
/// that calibration is not the cause.
Verdict verdict_of(const Accuracy& accuracy, const std::vector<AccuracyFigure>& figures,
                   bool exact_scanner);

using CloudOfScan = std::function<Cloud(const std::string& scan)>;

/// Finds the artefacts in the scans' clouds, one cloud at a time, and measures them. Spheres: uses
/// points seen at up to 60 degrees from the normal, but not within 40 degrees of a ball bar's rod.
/// Planes, which must have two thirds of a cloud's points: uses one connected piece of points
/// nearer than 1 % of the plane's length (2.5 times the median distance of its points from their
/// centre), without a rim of 5 pixels, where blur moves points. Throws Error with the scan's name
/// if an artefact is not found or repeated scans are copies.
Accuracy measure_accuracy(const Artefacts& artefacts, const CloudOfScan& cloud_of);

}  // namespace slipstream
