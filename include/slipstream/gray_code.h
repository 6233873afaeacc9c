#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/phase_shifting.h"

// Codings of stripes numbered by a Gray code, alone or with sinusoids. See Strategy.
namespace slipstream {

/// Stripes numbered by a Gray or plain binary code: y to half a stripe, for any response.
struct GrayCode {
  static constexpr std::string_view name = "gray";

  std::optional<int> bits{};  ///< default: enough for `stripes` if those are given, else 10
  /// How to separate bright from dark: "white-black", two frames after the bits; "inverse", the
  /// negative after each bit; "mean" of all frames; "none", half way between the darkest and the
  /// brightest bit.
  std::string reference = "white-black";
  std::optional<double> stripes{};  ///< across the field; default 2^bits
  bool plain = false;               ///< plain binary instead of Gray
  bool least_first = false;         ///< narrowest stripes first

  static void for_each_setting(auto& self, const auto& visit) {
    visit("bits", "bits of the code, one frame each; default: as many as the stripes need",
          self.bits);
    visit("reference", "threshold for bright: white-black, inverse, mean or none", self.reference);
    visit("stripes", "number of stripes across the field; at most 2^bits", self.stripes);
    visit("plain", "plain binary code instead of a Gray code", self.plain);
    visit("least_first", "show the least significant bit first", self.least_first);
  }

  void require_valid() const;
  [[nodiscard]] int shown_bits() const;  ///< `bits` or its default
  [[nodiscard]] Layout layout() const;
};

/// A Gray code whose wide stripes are XORed with narrow ones, so that interreflections and
/// subsurface scattering average out in every frame (Gupta et al., IJCV 102, 2013).
struct ExclusiveOrGray {
  static constexpr std::string_view name = "xor-gray";

  int bits = 10;
  int base = 1;  ///< 1: the narrowest stripes (XOR-02), 2: the next ones (XOR-04)
  std::string reference = "inverse";  ///< as in GrayCode

  static void for_each_setting(auto& self, const auto& visit) {
    visit("bits", "bits of the code, one frame each", self.bits);
    visit("base", "stripes XORed into all bits: 1 the narrowest, 2 the next", self.base);
    visit("reference", "threshold for bright: white-black, inverse, mean or none", self.reference);
  }

  void require_valid() const;
  [[nodiscard]] Layout layout() const;
};

/// N-step sinusoids of many periods and a Gray code for the period: Liu 2010, Eq. (1.18). Its
/// stripes may also be of any smaller width.
struct GrayPhase {
  static constexpr std::string_view name = "gray-phase";

  int steps = 4;
  double periods = 32;
  std::optional<int> bits{};  ///< default: enough for `stripes` if given, else for `periods`
  /// Across the field, at least one per period, without the complementary bit, which doubles them;
  /// default: one per period, twice as many for each further bit.
  std::optional<double> stripes{};
  /// Adds one bit with stripes of half the width. With one stripe per period it tolerates code
  /// edges up to a quarter of a period from the phase wraps; default: true, false if `stripes` is
  /// given.
  std::optional<bool> complementary{};
  /// As in GrayCode, but "mean" and "none" are those of the sinusoids.
  std::string reference = "mean";
  Shifts shifts{};
  std::vector<double> angles{};  ///< degrees; replace `steps`: see Sinusoid

  static void for_each_setting(auto& self, const auto& visit) {
    visit_steps(self, visit);
    visit("periods", "periods of each sinusoid across the field", self.periods);
    visit("bits", "bits of the code, one frame each", self.bits);
    visit("stripes", "number of stripes across the field", self.stripes);
    visit("complementary", "add a bit with stripes of half the width: true or false",
          self.complementary);
    visit("reference", "threshold for bright: white-black, inverse, mean or none", self.reference);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const;
  [[nodiscard]] std::vector<Sinusoid> runs() const { return {{steps, periods, shifts, angles}}; }
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
