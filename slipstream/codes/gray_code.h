#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {

/// Stripes numbered by a Gray code, or a plain binary one: a coordinate to half a stripe, whatever
/// the projector's response.
struct GrayCode {
  static constexpr std::string_view name = "gray";

  int bits = 10;
  /// What bright is told from dark by: "white-black", two frames after those of the bits;
  /// "inverse", after each bit its negative; "mean" of all frames; "none", half way
  /// between the brightest and the darkest of the bits.
  std::string reference = "white-black";
  std::optional<double> stripes{};  ///< across the field; 2^bits where not given
  bool plain = false;               ///< binary numbers
  bool least_first = false;         ///< the narrowest stripes first

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("bits", "pictures of the code", self.bits);
    visit("reference", "white-black, inverse, mean or none: what is bright", self.reference);
    visit("stripes", "across the projector field, at most 2^bits", self.stripes);
    visit("plain", "a plain binary code, no Gray code", self.plain);
    visit("least_first", "the least significant bit first", self.least_first);
  }
  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

/// A Gray code whose wide stripes are shown in exclusive-or with narrow ones, so that no frame has
/// wide stripes: light that is reflected from surface to surface, or scattered below one, averages
/// out (Gupta et al., IJCV 102, 2013).
struct ExclusiveOrGray {
  static constexpr std::string_view name = "xor-gray";

  int bits = 10;
  int base = 1;  ///< 1: the narrowest stripes (XOR-02), 2: the next ones (XOR-04)
  std::string reference = "inverse";  ///< as GrayCode's

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("bits", "pictures of the code", self.bits);
    visit("base", "1: all bits with the narrowest stripes, 2: with the next", self.base);
    visit("reference", "white-black, inverse, mean or none: what is bright", self.reference);
  }
  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

/// N-step sinusoids of many periods, and a Gray code that says which period it is: Liu 2010, Eq.
/// (1.18).
struct GrayPhase {
  static constexpr std::string_view name = "gray-phase";

  int steps = 4;
  double periods = 32;
  std::optional<int> bits{};  ///< enough for a stripe of each period where not given
  /// One bit more, of stripes half as wide, forgives edges of the code that are up to a quarter of
  /// a period from where the phase wraps; shown where not said otherwise.
  std::optional<bool> complementary{};
  /// As GrayCode's, but "mean" is that of the sinusoids, as is "none".
  std::string reference = "mean";
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("periods", "across the projector field, of each sinusoid", self.periods);
    visit("bits", "pictures of the code", self.bits);
    visit("complementary", "one bit more, of half a period: true or false", self.complementary);
    visit("reference", "white-black, inverse, mean or none: what is bright", self.reference);
    visit_shifts(self.shifts, visit);
  }
  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
