#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace slipstream {

/// Stripes that are bright or dark in some frames, which together number them: a Gray code or a
/// plain binary one.
struct Code {
  double stripes = 2;         ///< across the field, 2 to 2^bits
  std::vector<int> frames{};  ///< of the bits, most significant first
  /// Where not empty, a frame for each bit that shows it with bright and dark exchanged.
  std::vector<int> inverses{};
  /// Else what is darker than a bright bit and brighter than a dark one: a weight for each frame of
  /// the scan. Empty too: what lies half way between the brightest and the darkest of the bits.
  std::vector<double> reference{};
  bool gray = true;  ///< neighbouring stripes differ in one bit
  /// The bit that the frames of all others show in exclusive-or with themselves.
  std::optional<int> base{};

  friend bool operator==(const Code&, const Code&) = default;
};

inline constexpr int most_code_bits = 20;

/// Throws Error, beginning with `name`, unless there are 1 to most_code_bits bits, as many inverses
/// or a weight for each frame, frames of the scan and enough bits for the stripes.
void require_valid(const Code& code, int frames, std::string_view name);

/// Whether the frame of that bit is bright at y in [0, 1].
bool is_bright(const Code& code, int bit, double y);

/// What the code says of one pixel.
struct CodeReading {
  int stripe = 0;  ///< counted from 0 at y = 0; past the last one where no stripe has that word
  /// How far the frames of the bits are from where bright turns to dark, grey levels: the second
  /// least of all bits (at a stripe's edge one of them is rightly in between), the least of one.
  double contrast = 0;
};

/// `intensities`: of all frames of the scan, one pixel's.
CodeReading read_code(const Code& code, std::span<const double> intensities);

/// The bits of a word, from those that frames show, most significant first.
int stripe_of(const Code& code, unsigned shown);

}  // namespace slipstream
