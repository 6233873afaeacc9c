#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/shift_settings.h"

namespace slipstream {

/// Several PMP scans in one, each of any number of periods: Liu 2010, Eq. (1.17) from band to band,
/// beats of the bands (heterodyne), or all of them at once (the number-theoretical way).
struct MultiFrequency {
  static constexpr std::string_view name = "multi-frequency";

  std::vector<int> steps{3};              ///< N of each band, or of all
  std::vector<double> periods{1, 6, 36};  ///< of each band, in the order shown
  /// "hierarchical", "heterodyne" or "number-theory"; empty: the first of these whose fringe orders
  /// six standard deviations of the noise leave right, else the one that noise disturbs least.
  std::string unwrapping{};
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("periods", "across the projector field, of each sinusoid", self.periods);
    visit("unwrapping", "hierarchical, heterodyne or number-theory", self.unwrapping);
    visit_shifts(self.shifts, visit);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  /// Pattern n at projector coordinate y, in [0, 1].
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;

 private:
  [[nodiscard]] int step_count(std::size_t band) const;
};

}  // namespace slipstream
