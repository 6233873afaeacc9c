#include "slipstream/io/plot.h"

#include <algorithm>
#include <cmath>

namespace slipstream {

PlotAxis round_axis(double low, double high, int count) {
  if (!(high > low)) {
    const double margin = low == 0 ? 1 : 0.1 * std::abs(low);
    low -= margin;
    high = low + 2 * margin;
  }
  const double raw = (high - low) / count;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (raw <= factor * power * (1 + 1e-9)) step = factor * power;
  }
  PlotAxis axis{step * std::floor(low / step + 1e-9), step * std::ceil(high / step - 1e-9), {}};
  const auto steps = static_cast<int>(std::lround((axis.high - axis.low) / step));
  for (int i = 0; i <= steps; ++i) axis.marks.push_back(axis.low + i * step);
  return axis;
}

std::vector<double> marks_between(double low, double high, int count) {
  std::vector<double> marks = round_axis(low, high, count).marks;
  std::erase_if(marks, [&](double mark) { return mark < low || mark > high; });
  return marks;
}

PlotAxis decade_axis(double low, double high, int count) {
  PlotAxis axis{std::floor(std::log10(low) + 1e-9), std::ceil(std::log10(high) - 1e-9), {}};
  if (axis.high <= axis.low) axis.high = axis.low + 1;
  const int decades = static_cast<int>(axis.high - axis.low);
  const int step = std::max(1, (decades + count - 1) / count);
  for (int i = 0; i <= decades; i += step) axis.marks.push_back(axis.low + i);
  return axis;
}

}  // namespace slipstream
