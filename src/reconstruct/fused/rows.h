#pragma once

#include <cstdint>
#include <variant>

// Shared by all row functions of the fused pass. Each processes one row of pixels, in float, and
// is compiled for each vector target. Arguments are not checked: rows must be at least
// `least_row_width` wide.
namespace slipstream {

/// Lanes of the widest vectors; the last vector of a row overlaps the one before it.
inline constexpr int least_row_width = 16;

/// State of a pixel between the stages; a pixel without flags is measured.
enum PixelFlag : std::int32_t {
  dark = 1,            ///< modulation below the threshold
  saturated = 2,       ///< a frame at full scale, if such pixels are dropped
  doubtful_order = 4,  ///< bands, or band and cue, disagree by more than the consensus allows
  dim = 8,  ///< modulation within the noise: the pixel does not vote on its neighbours' orders
};

/// A row of each frame, 8 or 16 bits per pixel.
using FrameRows = std::variant<const std::uint8_t* const*, const std::uint16_t* const*>;

}  // namespace slipstream
