#pragma once

#include <optional>
#include <string>

#include "slipstream/image.h"

namespace slipstream {

inline constexpr const char* map_forms =
    "coordinate (0 to 1 across the projector), pixels (of the projector), phase:PERIODS "
    "(unwrapped, rad, 2 pi PERIODS across the projector) or periods:PERIODS (the same in periods)";

enum class MapUnit { coordinate, pixels, phase, periods };

/// Meaning of the values of a map of another program: at projector coordinate y, 0 to 1 across the
/// field, the value is origin + y * span, or with `backwards` origin - y * span.
struct MapForm {
  MapUnit unit = MapUnit::coordinate;
  double periods = 0;  ///< across the field; of phase and periods only
  /// The value where y is 0; default: 0, or with `backwards` the value at the field's other end.
  std::optional<double> origin{};
  bool backwards = false;

  friend bool operator==(const MapForm&, const MapForm&) = default;
};

/// The form of one of map_forms. Throws Error for another.
MapForm map_form_named(const std::string& name);

/// "phase:16".
std::string name_of(const MapForm& form);

/// Difference of the values at both ends of the field, positive. `length`: projector pixels along
/// the axis.
double span_of(const MapForm& form, int length);

/// MapForm::origin, or its default.
double origin_of(const MapForm& form, int length);

/// Projector coordinates, 0 to 1; NaN where invalid. Throws Error if no value is finite, or if a
/// phase of several periods is wrapped.
Image<double> coordinates_of_map(Image<double> map, const MapForm& form, int length);

}  // namespace slipstream
