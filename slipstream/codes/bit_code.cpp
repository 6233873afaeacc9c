#include "slipstream/codes/bit_code.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

int bit_count(const Code& code) {
  return static_cast<int>(code.frames.size());
}

/// Where the bit stands in a word.
unsigned place(const Code& code, int bit) {
  return 1U << static_cast<unsigned>(bit_count(code) - 1 - bit);
}

/// All bits but the base.
unsigned others(const Code& code) {
  return ((1U << code.frames.size()) - 1) & ~place(code, *code.base);
}

double reference_of(const Code& code, std::span<const double> I) {
  if (!code.reference.empty()) {
    return std::inner_product(I.begin(), I.end(), code.reference.begin(), 0.0);
  }
  double darkest = std::numeric_limits<double>::infinity(), brightest = 0;
  for (const int frame : code.frames) {
    darkest = std::min(darkest, I[static_cast<std::size_t>(frame)]);
    brightest = std::max(brightest, I[static_cast<std::size_t>(frame)]);
  }
  return (darkest + brightest) / 2;
}

}  // namespace

void require_valid(const Code& code, int frames, std::string_view name) {
  const int bits = bit_count(code);
  if (bits < 1 || bits > most_code_bits) {
    throw Error(fmt::format("{}: {} bits are out of range; 1 to {}", name, bits, most_code_bits));
  }
  if (!(code.stripes >= 2 && code.stripes <= std::exp2(bits))) {
    throw Error(fmt::format("{}: {} bits number {} stripes; {:g} are out of range", name, bits,
                            std::exp2(bits), code.stripes));
  }
  const auto is_frame = [&](int frame) { return frame >= 0 && frame < frames; };
  const bool all = std::all_of(code.frames.begin(), code.frames.end(), is_frame) &&
                   std::all_of(code.inverses.begin(), code.inverses.end(), is_frame);
  const bool compared =
      code.inverses.empty()
          ? code.reference.empty() || static_cast<int>(code.reference.size()) == frames
          : code.inverses.size() == code.frames.size();
  if (!all || !compared || (code.base && !(*code.base >= 0 && *code.base < bits))) {
    throw Error(fmt::format("{}: the code's bits are not among its {} frames", name, frames));
  }
}

bool is_bright(const Code& code, int bit, double y) {
  const double last = std::ceil(code.stripes) - 1;
  const auto stripe =
      static_cast<unsigned>(std::clamp(std::floor(y * code.stripes + 1e-9), 0.0, last));
  unsigned word = code.gray ? stripe ^ (stripe >> 1U) : stripe;
  if (code.base && (word & place(code, *code.base)) != 0) word ^= others(code);
  return (word & place(code, bit)) != 0;
}

int stripe_of(const Code& code, unsigned shown) {
  if (code.base && (shown & place(code, *code.base)) != 0) shown ^= others(code);
  if (!code.gray) return static_cast<int>(shown);
  for (unsigned shift = 1; shift < most_code_bits; shift *= 2) shown ^= shown >> shift;
  return static_cast<int>(shown);
}

CodeReading read_code(const Code& code, std::span<const double> I) {
  const double reference = reference_of(code, I);
  double least = std::numeric_limits<double>::infinity(), second = least;
  unsigned shown = 0;
  for (std::size_t bit = 0; bit < code.frames.size(); ++bit) {
    const double level = I[static_cast<std::size_t>(code.frames[bit])];
    const double above = code.inverses.empty()
                             ? level - reference
                             : (level - I[static_cast<std::size_t>(code.inverses[bit])]) / 2;
    shown = 2 * shown + (above > 0 ? 1U : 0U);
    second = std::min(second, std::max(least, std::abs(above)));
    least = std::min(least, std::abs(above));
  }
  return {stripe_of(code, shown), code.frames.size() > 1 ? second : least};
}

}  // namespace slipstream
