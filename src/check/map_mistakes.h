#pragma once

#include <vector>

#include "check/possible_mistakes.h"
#include "geometry/map_form.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// A mistake about a map. Undone, each coordinate y becomes `scale` y + `shift`.
struct MapMistake {
  PossibleMistake mistake;
  double scale = 1, shift = 0;
};

/// The mistakes that may explain a map, simplest first: another unit, origin, number of periods or
/// direction than `form`, and those of geometric_mistakes.
std::vector<MapMistake> possible_map_mistakes(const MapForm& form, const Scanner& scanner,
                                              Axis axis);

}  // namespace slipstream
