#pragma once

#include <cstdint>
#include <vector>

// See sinusoid_rows.h.
namespace slipstream {

/// How the bits of a Code become a coordinate.
struct CodeStage {
  std::vector<int> frames{};    ///< of the bits, most significant first; 1 or more
  std::vector<int> inverses{};  ///< to compare each with; empty: with the row's reference
  bool gray = true;
  std::int32_t base = 0;    ///< the bit that the others are shown in exclusive-or with; 0: none
  std::int32_t others = 0;  ///< those
  float stripe = 1;         ///< its width, fields
};

/// The coordinate of the middle of each pixel's stripe. `reference`: what is darker than a bright
/// bit, for each pixel, grey levels; null where there are inverses.
void code_row(const CodeStage& stage, int width, const std::uint8_t* const* frames,
              const float* reference, float* coordinate);
void code_row(const CodeStage& stage, int width, const std::uint16_t* const* frames,
              const float* reference, float* coordinate);

}  // namespace slipstream
