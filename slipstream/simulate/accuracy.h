#pragma once

#include <filesystem>
#include <string>

#include "slipstream/cloud/cloud.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/simulate/virtual_world.h"

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

/// How a sphere's or a plane's points deviate from the shape of least squares, without the 0.3 % of
/// them that VDI/VDE 2634 part 2 allows to leave out; mm.
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
/// count points seen at up to 60 degrees from the normal, unless within 40 degrees of a ball bar's
/// rod. Of a plane, which must hold two thirds of a cloud's points, count those nearer than 1 % of
/// its length (2.5 times the median distance of its points from their middle) in one piece, without
/// a rim of 5 pixels, where blur moves points. Throws Error, naming the scan, where an artefact is
/// not found, or where repeated scans are copies.
Accuracy measure_accuracy(const Artefacts& artefacts, const CloudOfScan& cloud_of);

/// Writes report.md and its pictures: the figures in mm and per mille of the measured volume's
/// diagonal (mm), each sphere and plane, and maps of the worst. `subject` says in a line what was
/// measured. Throws WorldError where it cannot be written.
void write_accuracy_report(const std::filesystem::path& folder, const std::string& subject,
                           const Accuracy& accuracy, std::optional<double> diagonal);

/// An acceptance test in the virtual world: artefacts exactly as certified, and the clouds of their
/// scans, taken when asked for.
struct Rehearsal {
  Artefacts artefacts;
  CloudOfScan cloud_of;
};

/// With L the diagonal of the measured volume, the largest cube about the middle of the working
/// volume that camera and projector see whole: a ball bar of spheres of 0.1 L, 0.35 L apart, in
/// seven positions (the cube's four diagonals and three near its sides), a square plane with sides
/// of 0.5 L in six, and ten scans of one of these that differ in noise alone. Ignores the scene of
/// `world`. Scans are reconstructed with `calibrated`: the world's scanner leaves the error of a
/// calibration out of the figures. Throws Error where the two see no volume in common.
Rehearsal rehearsal(const VirtualWorld& world, const Sequence& sequence, const Scanner& calibrated,
                    const ReconstructSettings& settings = {});

}  // namespace slipstream
