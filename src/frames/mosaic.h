#pragma once

#include <cstdint>
#include <string>

#include "slipstream/frame_source.h"
#include "slipstream/image.h"

namespace slipstream {

/// The colours of the first two pixels of a Bayer mosaic, e.g. "RG" of "RG", "RGGB" or "BayerRG8".
/// Throws Error for any other text.
std::string mosaic_named(const std::string& text);

/// Turns a Bayer mosaic grey: (R + 2 G + B) / 4 by the weights 1 2 1 over rows and columns, for any
/// order of the filters. Full scale if one of the nine values is.
void make_grey(Frame& frame);

/// Red, green and blue of each pixel side by side: its own value, and of the other colours the mean
/// of the neighbours. `mosaic`: of mosaic_named. Pixels of 8 or 16 bits.
template <class Pixel>
Image<Pixel> demosaiced(const Image<Pixel>& raw, const std::string& mosaic);

extern template Image<std::uint8_t> demosaiced(const Image<std::uint8_t>&, const std::string&);
extern template Image<std::uint16_t> demosaiced(const Image<std::uint16_t>&, const std::string&);

}  // namespace slipstream
