#pragma once

#include <array>
#include <span>

namespace slipstream {

/// The wrapped phase of three steps without an arctangent (Huang and Zhang, Applied Optics 45(21),
/// 2006): which intensity is the greatest and which the least says in which sixth of the circle it
/// lies, and a table of the ratio (middle - least) / (greatest - least) where in there.
class IntensityRatio {
 public:
  IntensityRatio();

  /// phi, rad, [0, 2 pi), to 2e-8; 0 where all three are alike. `intensities`: of Eq. (1.1), N = 3.
  [[nodiscard]] double wrapped_phase(std::span<const double> intensities) const;

 private:
  static constexpr int segments = 4096;

  std::array<double, segments + 1> angle_{};  ///< rad, [0, pi / 3], at ratio i / segments
};

}  // namespace slipstream
