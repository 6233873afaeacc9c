#pragma once

#include <optional>
#include <span>
#include <vector>

#include "check/fit.h"
#include "check/geometry_evidence.h"
#include "slipstream/image.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Where a map ends along a line of equal coordinates, as at the end of the projector's light.
struct LightEnd {
  double coordinate = 0;
  double step = 0;  ///< change of the coordinate from pixel to pixel there, positive
};

/// Evidence about a map of coordinates.
struct MapEvidence {
  std::vector<CoordinateSample> samples;  ///< spread over the map
  /// Ends with the least and with the largest coordinates, if a line of them is long enough that
  /// hardly an object has such an edge.
  std::optional<LightEnd> low, high;
};

/// `coordinates`: NaN where invalid.
MapEvidence map_evidence(const Image<double>& coordinates);

/// The evidence after each coordinate y has become `scale` y + `shift`.
MapEvidence changed(MapEvidence evidence, double scale, double shift);

/// Evidence of a map compared with limits.
struct MapFit {
  /// Correct maps of the virtual scanner: 0.5.
  static constexpr double most_end_error = 1.5;
  /// Wrong fringe orders lie anywhere.
  static constexpr double most_exceeding = 0.02;

  Fit scan{};                  ///< its geometry; the rest is unknown
  double end_error = 0;        ///< distance of an end from the field's, steps; the larger one
  bool end_is_beyond = false;  ///< that end lies outside of the field
  double exceeding = 0;        ///< share of the coordinates outside of the field

  [[nodiscard]] bool ends_fit() const { return end_error <= most_end_error; }
  /// Neither values nor an end outside of the field.
  [[nodiscard]] bool is_in_field() const {
    return exceeding <= most_exceeding && (ends_fit() || !end_is_beyond);
  }
  [[nodiscard]] bool all() const { return scan.all() && ends_fit() && is_in_field(); }
  /// As Fit::misfit.
  [[nodiscard]] double misfit() const;
};

MapFit fit_of(const MapEvidence& evidence, const Scanner& scanner, Axis axis,
              const PictureTurn& turn = {});

}  // namespace slipstream
