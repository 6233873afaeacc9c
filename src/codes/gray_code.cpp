#include "slipstream/gray_code.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

constexpr std::array<std::string_view, 4> references{"white-black", "inverse", "mean", "none"};

void require_known(std::string_view name, int bits, std::string_view reference) {
  throw_if(bits < 1 || bits > most_code_bits, "{}: {} bits are out of range; 1 to {}", name, bits,
           most_code_bits);
  throw_if(std::ranges::find(references, reference) == references.end(),
           "{}: reference '{}' is unknown; expected one of: {}", name, reference,
           fmt::join(references, ", "));
}

/// Frames of the code, including those it is compared with.
int frame_count(int bits, std::string_view reference) {
  return reference == "inverse" ? 2 * bits : reference == "white-black" ? bits + 2 : bits;
}

/// The bits in frames from `first` on, out of `frames`.
Code code_in_frames(int frames, int first, int bits, std::string_view reference) {
  Code code{.stripes = std::exp2(bits)};

  // With inverses, each bit's frame is followed by its negative.
  const int apart = reference == "inverse" ? 2 : 1;
  for (int bit = 0; bit < bits; ++bit) {
    code.frames.push_back(first + apart * bit);
    if (apart == 2) code.inverses.push_back(first + apart * bit + 1);
  }

  // The threshold is the mean of white and black, which follow the bits, or of all bits.
  if (apart == 2 || reference == "none") return code;
  code.reference.resize(frames);
  const auto begin = code.reference.begin() + first;
  if (reference == "white-black") std::fill_n(begin + bits, 2, 0.5);
  if (reference == "mean") std::fill_n(begin, bits, 1.0 / bits);

  return code;
}

/// The narrowest stripes as a band, for modulation and mean; its phase has no meaning.
Layout layout_of(const Code& code, int frames) {
  // The finest frame of a Gray code has two bright stripes, then two dark ones: four to a period.
  const std::vector<double> none(frames);
  Band band{.periods = code.stripes / 4, .cosine = none, .sine = none, .mean = code.reference};

  // The mean is half of a bit and its inverse, the threshold, or the mean of all frames.
  const int narrowest = code.frames.back();
  if (!code.inverses.empty()) {
    band.mean = none;
    band.mean[narrowest] = band.mean[code.inverses.back()] = 0.5;
  } else if (code.reference.empty()) {
    band.mean.assign(frames, 1.0 / frames);
  }

  // The finest frame minus the mean: its amplitude is the modulation.
  for (std::size_t n = 0; n < band.mean.size(); ++n) band.cosine[n] = -band.mean[n];
  band.cosine[narrowest] += 1;

  return {.frames = frames,
          .bands = {std::move(band)},
          .code = code,
          .unwrapping = Unwrapping::code_alone};
}

/// Bits of a code with one stripe per period; at most 64, beyond what any code may have.
int bits_for(double periods) {
  constexpr double most = 64;
  if (!(periods > 1)) return 1;
  return static_cast<int>(std::min(most, std::ceil(std::log2(periods) - 1e-9)));
}

/// Bits of GrayPhase without the complementary one.
int bits_of(const GrayPhase& coding) {
  return coding.bits.value_or(bits_for(coding.stripes.value_or(coding.periods)));
}

/// Bits that GrayPhase::complementary adds to the code.
int complementary_bits(const GrayPhase& coding) {
  return coding.complementary.value_or(!coding.stripes) ? 1 : 0;
}

}  // namespace

int GrayCode::shown_bits() const {
  constexpr int usual = 10;
  return bits.value_or(stripes ? bits_for(*stripes) : usual);
}

void GrayCode::require_valid() const {
  require_known(name, shown_bits(), reference);
  slipstream::require_valid(*layout().code, layout().frames, name);
}

Layout GrayCode::layout() const {
  const int shown = shown_bits(), frames = frame_count(shown, reference);
  Code code = code_in_frames(frames, 0, shown, reference);
  code.stripes = stripes.value_or(code.stripes);
  code.gray = !plain;

  // Bit 0, the most significant one, moves to the last frame.
  if (least_first) {
    std::ranges::reverse(code.frames);
    std::ranges::reverse(code.inverses);
  }

  return layout_of(code, frames);
}

void ExclusiveOrGray::require_valid() const {
  require_known(name, bits, reference);
  throw_if(base < 1 || base > 2 || base >= bits,
           "xor-gray: base {} of {} bits is out of range; 1 or 2", base, bits);
}

Layout ExclusiveOrGray::layout() const {
  const int frames = frame_count(bits, reference);
  Code code = code_in_frames(frames, 0, bits, reference);
  code.base = bits - base;
  return layout_of(code, frames);
}

void GrayPhase::require_valid() const {
  slipstream::require_valid(runs().front(), "gray-phase");
  constexpr double rounded = 1e-9;  // of a width in pixels
  const double coded = stripes.value_or(periods);
  throw_if(!(coded >= periods * (1 - rounded)),
           "gray-phase: a code of {:g} stripes is too short for {:g} periods", coded, periods);

  const int shown = bits_of(*this);
  require_known(name, shown + complementary_bits(*this), reference);

  throw_if(shown < bits_for(periods),
           "gray-phase: {} bits are too few for {:g} periods, which require {}", shown, periods,
           bits_for(periods));
}

Layout GrayPhase::layout() const {
  const int added = complementary_bits(*this), shown = bits_of(*this) + added;
  const int first = runs().front().frames(), frames = first + frame_count(shown, reference);

  Layout layout{
      .frames = frames, .bands = {band_of(runs().front(), frames)}, .unwrapping = Unwrapping::code};

  // By default a stripe per period, and twice the number of stripes for each further bit.
  layout.code = code_in_frames(frames, first, shown, reference);
  const double usual = periods * std::exp2(bits_of(*this) - bits_for(periods));
  layout.code->stripes = stripes.value_or(usual) * std::exp2(added);

  // The mean of the sinusoid's frames also separates bright from dark.
  if (reference == "mean" || reference == "none")
    layout.code->reference = layout.bands.front().mean;

  return layout;
}

}  // namespace slipstream
