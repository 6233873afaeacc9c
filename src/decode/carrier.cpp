#include "decode/carrier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numeric>
#include <vector>

#include "base/numbers.h"

namespace slipstream {
namespace {

/// Power of a frequency along short lines spread over an image, with a Hann window.
class Lines {
 public:
  /// `cycles`: per pixel along the lines.
  Lines(const Image<float>& picture, bool along_rows, double cycles)
      : picture_(picture), along_rows_(along_rows) {
    constexpr double periods = 5;

    const int length = along_rows ? picture.width() : picture.height();
    const int longest = std::max(length - 2, 1);

    // As many pixels as hold five periods, within the picture.
    cosine_.resize(static_cast<std::size_t>(
        std::clamp(static_cast<int>(std::lround(periods / cycles)), 1, longest)));
    sine_.resize(cosine_.size());

    // A Hann window, normalised, on a wave that starts at the line's beginning.
    const auto count = static_cast<double>(cosine_.size());
    for (std::size_t i = 0; i < cosine_.size(); ++i) {
      const auto at = static_cast<double>(i);
      const double weight = (1 - std::cos(two_pi * (at + 0.5) / count)) / count;
      cosine_[i] = static_cast<float>(weight * std::cos(two_pi * cycles * at));
      sine_[i] = static_cast<float>(-weight * std::sin(two_pi * cycles * at));
    }
  }

  /// Sum of squared amplitudes over the lines.
  [[nodiscard]] double power() const {
    double power = 0;
    for_each([&](int first, int line) { power += std::norm(sum(first, line)); });
    return power;
  }

  /// Phase advance near the frequency, cycles per pixel: along the lines and across them.
  [[nodiscard]] std::pair<double, double> advance() const {
    // Mean turn of the phase from each place to the next one, weighted by power.
    std::complex<double> along, across;
    for_each([&](int first, int line) {
      const std::complex<double> here = std::conj(sum(first, line));
      along += here * sum(first + 1, line);
      across += here * sum(first, line + 1);
    });

    return {std::arg(along) / two_pi, std::arg(across) / two_pi};
  }

 private:
  template <class Visit>
  void for_each(const Visit& visit) const {
    constexpr int lines = 12;
    const int length = along_rows_ ? picture_.width() : picture_.height();
    const int count = along_rows_ ? picture_.height() : picture_.width();

    // Lines spread over the picture, each in pieces that overlap by half.
    const int size = static_cast<int>(cosine_.size()), step = std::max(size / 2, 1);
    for (int line = count / (2 * lines); line + 1 < count; line += std::max(count / lines, 1)) {
      for (int first = 0; first + size < length; first += step) visit(first, line);
    }
  }

  [[nodiscard]] std::complex<double> sum(int first, int line) const {
    constexpr std::size_t lanes = 8;  // independent sums, for vectors
    std::array<float, lanes> cosines{}, sines{};

    const float* const from = along_rows_ ? picture_.row(line) + first : picture_.row(first) + line;
    const std::size_t count = cosine_.size();
    const std::size_t stride = along_rows_ ? 1 : static_cast<std::size_t>(picture_.width());

    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        const float value = from[(i + lane) * stride];
        cosines[lane] += cosine_[i + lane] * value;
        sines[lane] += sine_[i + lane] * value;
      }
    }
    // The rest that fills no vector.
    for (std::size_t lane = 0; i < count; ++i, ++lane) {
      cosines[lane] += cosine_[i] * from[i * stride];
      sines[lane] += sine_[i] * from[i * stride];
    }

    return {std::accumulate(cosines.begin(), cosines.end(), 0.0),
            std::accumulate(sines.begin(), sines.end(), 0.0)};
  }

  const Image<float>& picture_;
  bool along_rows_;
  std::vector<float> cosine_, sine_;  ///< with the window applied
};

}  // namespace

std::vector<Carrier> found_carriers(const Image<float>& picture, const std::vector<double>& periods,
                                    bool along_rows) {
  constexpr double least_scale = 0.4, largest_scale = 2.5, step = 1.06;
  constexpr double finest = 0.4;  // cycles per pixel

  const double length = along_rows ? picture.width() : picture.height();

  // 1. The common scale of picture and field at which all carriers together are strongest.
  double strongest = -1, scale = 1;
  for (double tried = least_scale; tried < largest_scale; tried *= step) {
    double power = 0;
    for (const double f : periods) {
      const double cycles = tried * f / length;
      if (cycles < finest) power += Lines(picture, along_rows, cycles).power();
    }

    if (power > strongest) {
      strongest = power;
      scale = tried;
    }
  }

  // 2. Each carrier by the advance of its phase near that scale.
  std::vector<Carrier> carriers;
  for (const double f : periods) {
    const double about = scale * f / length;
    const auto [along, across] = Lines(picture, along_rows, about).advance();
    carriers.push_back(along_rows ? Carrier{along, across} : Carrier{across, along});
  }

  return carriers;
}

}  // namespace slipstream
