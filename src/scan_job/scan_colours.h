#pragma once

#include "cloud/seen_colours.h"
#include "slipstream/scan.h"

namespace slipstream {

/// Colours of a cloud's points: from the scan's other colour camera if it has one, else the scan's
/// own; empty without colours.
inline Image<Colour> colours_of(const Cloud& cloud, const Scan& scan) {
  const auto& other = scan.colour_camera;
  return other ? colours_seen_by(cloud, other->picture, other->lens, other->pose) : scan.colour;
}

}  // namespace slipstream
