#include "slipstream/codes/strategy.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/motion_window.h"
#include "slipstream/codes/phase_shifting.h"

namespace slipstream {
namespace {

int whole(double number) {
  if (number != std::floor(number) || std::abs(number) > std::numeric_limits<int>::max()) {
    throw Error(fmt::format("{} is not a whole number", number));
  }
  return static_cast<int>(number);
}

}  // namespace

SettingValue::SettingValue(const std::vector<double>& numbers)
    : text_(fmt::format("{}", fmt::join(numbers, ","))) {}

std::string SettingValue::text_of(double number) {
  return fmt::format("{}", number);
}

void SettingValue::read(std::vector<double>& values) const {
  values.clear();
  const char* at = text_.data();
  const char* const end = at + text_.size();
  while (true) {
    double number = 0;
    const auto [after, failure] = std::from_chars(at, end, number);
    if (failure != std::errc() || !std::isfinite(number) || (after != end && *after != ',')) {
      throw Error(fmt::format("'{}' is no number, nor numbers with commas between", text_));
    }
    values.push_back(number);
    if (after == end) return;
    at = after + 1;
  }
}

void SettingValue::read(std::vector<int>& values) const {
  std::vector<double> numbers;
  read(numbers);
  values.clear();
  for (const double number : numbers) values.push_back(whole(number));
}

double SettingValue::number() const {
  std::vector<double> numbers;
  read(numbers);
  if (numbers.size() != 1) throw Error(fmt::format("'{}' is not one number", text_));
  return numbers.front();
}

void SettingValue::read(double& value) const {
  value = number();
}

void SettingValue::read(int& value) const {
  value = whole(number());
}

void SettingValue::read(std::string& value) const {
  value = text_;
}

void SettingValue::read(bool& value) const {
  value = text_ == "true" || text_ == "1";
  if (!value && text_ != "false" && text_ != "0") {
    throw Error(fmt::format("'{}' is neither true nor false", text_));
  }
}

Strategy::Strategy() : Strategy(PhaseMeasuring{}) {}

void Strategy::show(std::vector<ShownSinusoid> sinusoids) {
  layout_ = {.frames = static_cast<int>(sinusoids.front().angle.size()),
             .bands = fitted_bands(sinusoids, name_),
             .unwrapping = sinusoids.size() > 1 ? Unwrapping::hierarchical : Unwrapping::none};
  shape_ = [sinusoids = std::move(sinusoids)](int n, double y, double across) {
    return composite_intensity(sinusoids, n, y, across);
  };
}

void Strategy::show_grid() {
  shape_ = [grid = demodulation_->grid](int n, double y, double across) {
    return grid_intensity(grid, n, y, across);
  };
  read_shape_ = [frames = demodulation_->frames](int n, double y) {
    return sine_cosine_mean_shape(n % 3, frames[static_cast<std::size_t>(n)].periods, y);
  };
}

Strategy Strategy::read_as() const {
  Strategy read = *this;
  if (demodulation_) {
    read.shape_ = read_shape_;
    read.read_ = true;
  }
  return read;
}

std::optional<Demodulation> Strategy::demodulation() const {
  return read_ ? std::nullopt : demodulation_;
}

std::string_view name_of(const Strategy& strategy) {
  return strategy.name();
}

Strategy Strategy::in_motion(int extra, int first) const {
  Strategy window = *this;
  window.layout_ = motion_window(layout_, extra, first);
  window.shape_ = [shape = shape_, first, N = layout_.frames](int n, double y, double across) {
    return shape((n + first) % N, y, across);
  };
  return window;
}

int frame_count(const Strategy& strategy) {
  const auto demodulation = strategy.demodulation();
  return demodulation ? demodulation->shown : strategy.layout().frames;
}

std::vector<int> step_counts(const Strategy& strategy) {
  return step_counts(strategy.layout());
}

bool has_coordinate(const Strategy& strategy) {
  return has_coordinate(strategy.layout());
}

double highest_frequency(const Strategy& strategy) {
  return highest_frequency(strategy.layout());
}

double carrier_periods(const Strategy& strategy) {
  double most = carrier_periods(strategy.layout());
  const auto demodulation = strategy.demodulation();
  if (!demodulation) return most;
  if (demodulation->grid.rows() > 1) most = std::max<double>(most, demodulation->grid.rows());
  for (const SpectralFrame& frame : demodulation->frames) {
    if (frame.across) most = std::max(most, frame.periods);
  }
  return most;
}

void require_resolved(const Strategy& strategy, Axis axis, Size projector) {
  const int projector_length = length_along(axis, projector);
  const auto& code = strategy.layout().code;
  if (code && code->stripes > projector_length) {
    throw Error(fmt::format("{}: {} stripes are too narrow for {} projector pixels; at most {}",
                            strategy.name(), code->stripes, projector_length, projector_length));
  }
  const auto require_shown = [](const char* what, double periods, int length) {
    if (2 * periods <= length) return;
    throw Error(
        fmt::format("{} {} is too high for {} projector pixels; at most {} periods can be shown",
                    what, periods, length, length / 2));
  };
  require_shown("frequency", highest_frequency(strategy), projector_length);
  require_shown("carrier", carrier_periods(strategy), length_along(across(axis), projector));
}

PatternSet pattern_set(const Strategy& strategy, Axis axis, const PatternLight& light) {
  require_valid(light);
  return {
      .count = frame_count(strategy),
      .axis = axis,
      .light = light,
      .shape = [strategy](int n, double y, double across) { return strategy.shape(n, y, across); },
      .carrier = carrier_periods(strategy) > 0};
}

}  // namespace slipstream
