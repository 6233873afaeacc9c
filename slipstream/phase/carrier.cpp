#include "slipstream/phase/carrier.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <utility>

namespace slipstream {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

/// Short lines of a picture under a Hann window, spread over it, and how strong a frequency is
/// there.
class Lines {
 public:
  /// `cycles`: per pixel along the lines, about.
  Lines(const Image<float>& picture, bool along_rows, double cycles)
      : picture_(picture), along_rows_(along_rows) {
    constexpr double periods = 5;
    const int length = along_rows ? picture.width() : picture.height();
    const int longest = std::max(length - 2, 1);
    window_.resize(static_cast<std::size_t>(
        std::clamp(static_cast<int>(std::lround(periods / cycles)), 1, longest)));
    for (std::size_t i = 0; i < window_.size(); ++i) {
      const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(window_.size());
      window_[i] = 1 - std::cos(two_pi * at);
    }
  }

  /// How strong the frequency is.
  [[nodiscard]] double power(double cycles) const {
    double power = 0;
    for_each([&](int first, int line) { power += std::norm(sum(first, line, cycles)); });
    return power;
  }

  /// How far the phase of what is near the frequency goes on from pixel to pixel, in cycles: along
  /// the lines and from one to the next.
  [[nodiscard]] std::pair<double, double> advance(double cycles) const {
    std::complex<double> along, across;
    for_each([&](int first, int line) {
      const std::complex<double> here = std::conj(sum(first, line, cycles));
      along += here * sum(first + 1, line, cycles);
      across += here * sum(first, line + 1, cycles);
    });
    return {std::arg(along) / two_pi, std::arg(across) / two_pi};
  }

 private:
  template <class Visit>
  void for_each(const Visit& visit) const {
    constexpr int lines = 12;
    const int length = along_rows_ ? picture_.width() : picture_.height();
    const int count = along_rows_ ? picture_.height() : picture_.width();
    const int size = static_cast<int>(window_.size()), step = std::max(size / 2, 1);
    for (int line = count / (2 * lines); line + 1 < count; line += std::max(count / lines, 1)) {
      for (int first = 0; first + size < length; first += step) visit(first, line);
    }
  }

  [[nodiscard]] std::complex<double> sum(int first, int line, double cycles) const {
    const std::complex<double> turn = std::polar(1.0, -two_pi * cycles);
    std::complex<double> wave = 1, sum = 0;
    double weights = 0;
    for (std::size_t i = 0; i < window_.size(); ++i) {
      const int at = first + static_cast<int>(i);
      const double value = along_rows_ ? picture_(at, line) : picture_(line, at);
      weights += window_[i];
      sum += window_[i] * value * wave;
      wave *= turn;
    }
    return sum / weights;
  }

  const Image<float>& picture_;
  bool along_rows_;
  std::vector<double> window_;
};

}  // namespace

std::vector<Carrier> found_carriers(const Image<float>& picture, const std::vector<double>& periods,
                                    bool along_rows) {
  constexpr double least_scale = 0.4, largest_scale = 2.5, step = 1.06;
  constexpr double finest = 0.4;  // cycles per pixel
  const double length = along_rows ? picture.width() : picture.height();
  double strongest = -1, scale = 1;
  for (double tried = least_scale; tried < largest_scale; tried *= step) {
    double power = 0;
    for (const double f : periods) {
      const double cycles = tried * f / length;
      if (cycles < finest) power += Lines(picture, along_rows, cycles).power(cycles);
    }
    if (power > strongest) {
      strongest = power;
      scale = tried;
    }
  }
  std::vector<Carrier> carriers;
  for (const double f : periods) {
    const double about = scale * f / length;
    const auto [along, across] = Lines(picture, along_rows, about).advance(about);
    carriers.push_back(along_rows ? Carrier{along, across} : Carrier{across, along});
  }
  return carriers;
}

}  // namespace slipstream
