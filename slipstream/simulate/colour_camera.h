#pragma once

#include "slipstream/frames/colour_channels.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// A projector and a camera in colour, and surfaces that are painted.
struct ColourDevices {
  ColourMixture mixture{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};  ///< its dark levels are 0
  /// How much of each channel's light paint takes at most, 0 to 1: its hue goes round every 40 mm
  /// of the surface. 0: all is grey.
  double paint = 0;
};

/// What such devices see of a mixture of 20 % and channels of unlike gain.
inline constexpr ColourMixture usual_mixture{
    {{1, 0.2, 0.05, 0}, {0.15, 0.9, 0.2, 0}, {0.05, 0.2, 0.75, 0}}};

/// As take_scan, but three patterns are shown at once, each picture's channels are three frames,
/// and there is a white picture. Throws Error where the patterns are not a multiple of three, the
/// scene moves or the paint is out of range.
VirtualScan take_colour_scan(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                             const Photometry& photometry, const ColourDevices& devices);

}  // namespace slipstream
