#include "slipstream/response/double_three_step.h"

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

#include "slipstream/base/parallel_rows.h"
#include "slipstream/decode/equations.h"

namespace slipstream {

using std::numbers::pi;

Image<double> double_three_step_phase(const FrameViews& frames, int first) {
  const PhaseEquations three_steps(3);
  Image<double> phase(frames.size());
  frames.part(first, 6).visit([&](const auto& views) {
    for_each_row(phase.height(), [&](int row) {
      for (int column = 0; column < phase.width(); ++column) {
        const auto I = [&](std::size_t n) { return static_cast<double>(views[n](column, row)); };
        const double even = three_steps(std::array{I(0), I(2), I(4)}).wrapped_phase;
        const double odd = three_steps(std::array{I(1), I(3), I(5)}).wrapped_phase + pi / 3;
        const double half_apart = std::remainder(odd - even, 2 * pi) / 2;
        const std::complex<double> middle = std::polar(1.0, even + half_apart);
        phase(column, row) = wrapped_angle(middle.imag(), middle.real());
      }
    });
  });
  return phase;
}

}  // namespace slipstream
