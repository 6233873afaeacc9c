#pragma once

#include <array>
#include <cstdint>

// Rows of depths to bits of what neighbours have to do with each other.
namespace slipstream {

/// What the frames' noise does to depth at a point P in the camera's frame, under a modulation of B
/// grey levels of the frames: sigma_Z = noise / B (projector_depth (P, 1))^2 Z / |parallax P|.
struct DepthNoise {
  float noise = 0;  ///< sigma of the projector coordinate times B
  std::array<float, 4> projector_depth{};
  std::array<float, 3> parallax{};
};

/// As shares of the depth.
struct DepthLimits {
  float step = 0;  ///< between neighbours of one surface, at most
  float bend = 0;  ///< of the second difference of three on a smooth one, at most
};

/// Which points P are trusted: those for which (projector_depth (P, 1))^2 (by_depth Z + constant)
/// is at most the modulation times |parallax P|.
struct TrustStage : DepthNoise {
  float by_depth = 0, constant = 0;
};

/// A row of the picture and its neighbours, and the words of bits that come of it. Depths are NaN
/// where there is no point; that also stands for the rows beyond the picture.
struct DepthRow {
  int width = 0;
  const float* above = nullptr;
  const float* here = nullptr;  ///< may be read one before the first and one after the last
  const float* below = nullptr;
  const float *x = nullptr, *y = nullptr;  ///< for the trust
  const float* modulation = nullptr;       ///< for the trust; null: all are trusted
  std::uint64_t* point = nullptr;          ///< there is one
  std::uint64_t* trusted = nullptr;        ///< there is one, and it is
  std::uint64_t* to_right = nullptr;       ///< on one surface with the next in the row
  std::uint64_t* to_below = nullptr;       ///< with the one in the next row
  std::uint64_t* bent_along = nullptr;     ///< the row does, from the one before to the one after
  std::uint64_t* bent_across = nullptr;    ///< the column does
};

/// Neighbours that are not both points are neither linked nor bent.
void compare_depths(const DepthLimits& limits, const TrustStage& trust, const DepthRow& row);

}  // namespace slipstream
