#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "slipstream/cloud.h"

// Compares neighbouring depths, and evaluates the relations as bits, 64 pixels of a row in a word.
namespace slipstream {

/// Limits relative to the depth.
struct DepthLimits {
  float step = 0;  ///< largest step between neighbours on one surface
  float bend = 0;  ///< largest second difference of three points on a smooth surface
};

/// A point P is trusted if (projector_depth (P, 1))^2 (by_depth Z + constant) is at most the
/// modulation times |parallax P|.
struct TrustStage : DepthNoise {
  float by_depth = 0, constant = 0;
};

/// A row of the picture and its neighbours, and the resulting words of bits. Depths are NaN without
/// a point, and in rows beyond the picture.
struct DepthRow {
  int width = 0;
  const float* above = nullptr;
  const float* here = nullptr;  ///< readable from one before the first to one after the last
  const float* below = nullptr;
  const float *x = nullptr, *y = nullptr;  ///< for trust
  const float* modulation = nullptr;       ///< for trust; null: all are trusted
  std::uint64_t* point = nullptr;          ///< the pixel has a point
  std::uint64_t* trusted = nullptr;        ///< the pixel has a trusted point
  std::uint64_t* to_right = nullptr;       ///< on one surface with the next pixel in the row
  std::uint64_t* to_below = nullptr;       ///< on one surface with the pixel below
  std::uint64_t* bent_along = nullptr;     ///< the row bends here
  std::uint64_t* bent_across = nullptr;    ///< the column bends here
};

/// Neighbours are neither linked nor bent unless both have points. Bits at the ends of the row that
/// compare with pixels beyond it have no meaning.
void compare_depths(const DepthLimits& limits, const TrustStage& trust, const DepthRow& row);

/// Words evaluated at once, of rows that follow each other with a word of zeros between them.
inline constexpr int block_words = 64;

/// Relations of the words of a block. Readable two rows and nine words before and after it.
struct RelationWords {
  std::ptrdiff_t stride = 0;  ///< words from row to row
  const std::uint64_t *point = nullptr, *trusted = nullptr;
  const std::uint64_t *to_right = nullptr, *to_below = nullptr;
  const std::uint64_t *bent_along = nullptr, *bent_across = nullptr;
};

/// Evidence of the neighbours against a trusted point.
struct EvidenceWords {
  std::uint64_t* mixed = nullptr;  ///< at the end of a surface or next to it, off its extrapolation
  std::uint64_t* at_edge = nullptr;  ///< beside a point to which it is not linked
  std::uint64_t* thin = nullptr;     ///< edges near on both sides, in the row or the column
  /// Surrounded by points: linked to all four but off them in row and column, or linked to none.
  std::uint64_t* outlier = nullptr;
};

/// Returns a bit for each word of the block with any evidence or a point that is not trusted.
std::uint64_t find_evidence(const RelationWords& relations, const EvidenceWords& evidence);

}  // namespace slipstream
