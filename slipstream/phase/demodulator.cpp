#include "slipstream/phase/demodulator.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/image/moving_mean.h"
#include "slipstream/image/parallel_rows.h"

namespace slipstream {
namespace {

constexpr float levels = 257;  // of 16 bits for one of 8
constexpr int bits = 16;
constexpr float smallest = 1e-9F;  // where nothing varies

bool is_of(const SpectralFrame& frame, const SpectralFrame& other) {
  return frame.periods == other.periods && frame.across == other.across;
}

void resize(Image<float>& image, Size size) {
  if (image.size() != size) image = Image<float>(size);
}

/// Calls `body(column, row)` for every pixel.
template <class Body>
void for_each_pixel(Size size, const Body& body) {
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) body(column, row);
  });
}

double distance(const Carrier& a, const Carrier& b) {
  return std::hypot(a.right - b.right, a.down - b.down);
}

}  // namespace

Demodulator::Demodulator(Demodulation how, Axis axis) : how_(std::move(how)), axis_(axis) {
  std::vector<SpectralFrame> first;
  for (const SpectralFrame& frame : how_.frames) {
    const auto known = std::find_if(first.begin(), first.end(),
                                    [&](const auto& other) { return is_of(frame, other); });
    band_of_.push_back(static_cast<std::size_t>(known - first.begin()));
    if (known == first.end()) first.push_back(frame);
  }
  bands_.resize(first.size());
  images_.resize(how_.frames.size());
}

const FrameViews& Demodulator::operator()(const FrameViews& shown) {
  if (shown.count() != how_.shown) {
    throw Error(fmt::format("{} frames given; the patterns are {}", shown.count(), how_.shown));
  }
  take(shown);
  find_carriers();
  const bool alone = bands_.size() == 1;
  const int square = odd_length(alone ? longest_ / 2 : longest_);
  take_mean(alone ? bands_.front().window : Size{square, square});
  for (Band& band : bands_) start(band);
  for (Band& band : bands_) take_near(band);
  if (alone) take_mean({square, square});
  for (Band& band : bands_) take_near(band);
  leave_out_unexplained();
  for (std::size_t n = 0; n < images_.size(); ++n) {
    if (images_[n].size() != shown.size()) images_[n] = Image<std::uint16_t>(shown.size());
    write(how_.frames[n], bands_[band_of_[n]], images_[n]);
  }
  views_.assign<std::uint16_t>(images_, bits, [](const Image<std::uint16_t>& image) {
    return ImageView<const std::uint16_t>(image);
  });
  return views_;
}

FrameSet Demodulator::frames() && {
  return {std::move(images_), bits};
}

void Demodulator::take(const FrameViews& shown) {
  const Size size = shown.size();
  for (Image<float>* const image : {&frame_, &mean_, &varying_, &near_cosine_, &near_sine_}) {
    resize(*image, size);
  }
  for (Band& band : bands_) {
    band.cosine = Image<float>(size);
    resize(band.sine, size);
  }
  saturated_ = saturation_mask(shown);
  const auto grey = static_cast<float>(255 / shown.full_scale());
  shown.visit([&](const auto& frames) {
    for_each_pixel(size, [&](int column, int row) {
      const float I = grey * static_cast<float>(frames[0](column, row));
      frame_(column, row) = I;
      if (how_.shown == 1) return;
      const float J = grey * static_cast<float>(frames[1](column, row));
      frame_(column, row) = (I - J) / 2;
      mean_(column, row) = (I + J) / 2;
    });
  });
}

void Demodulator::find_carriers() {
  for (const bool across : {false, true}) {
    std::vector<double> periods;
    std::vector<std::size_t> of;
    for (std::size_t n = 0; n < how_.frames.size(); ++n) {
      const SpectralFrame& frame = how_.frames[n];
      if (frame.across != across || std::count(of.begin(), of.end(), band_of_[n]) > 0) continue;
      periods.push_back(frame.periods);
      of.push_back(band_of_[n]);
    }
    if (periods.empty()) continue;
    const auto found = found_carriers(frame_, periods, (axis_ == Axis::x) != across);
    for (std::size_t i = 0; i < of.size(); ++i) bands_[of[i]].carrier = found[i];
  }
  longest_ = 1;
  for (Band& band : bands_) {
    const Carrier k = band.carrier;
    double nearest = distance(k, {});
    longest_ = std::max(longest_, 1 / nearest);
    for (const Band& other : bands_) {
      if (&other == &band) continue;
      nearest = std::min({nearest, distance(k, other.carrier),
                          distance(k, {-other.carrier.right, -other.carrier.down})});
    }
    const bool alone = bands_.size() == 1;
    const int along = odd_length(1 / nearest), across = odd_length((alone ? 0.25 : 1) / nearest);
    band.window = std::abs(k.right) > std::abs(k.down) ? Size{along, across} : Size{across, along};
  }
}

/// Of one frame: the mean of what the carriers leave, and what varies about it.
void Demodulator::take_mean(Size window) {
  if (how_.shown == 2) {
    varying_ = frame_;
    return;
  }
  mean_ = frame_;
  for (const Band& band : bands_) {
    for_each_pixel(mean_.size(),
                   [&](int column, int row) { mean_(column, row) -= band.cosine(column, row); });
  }
  take_moving_mean(mean_, window, scratch_);
  for_each_pixel(mean_.size(), [&](int column, int row) {
    varying_(column, row) = frame_(column, row) - mean_(column, row);
  });
}

/// To exp(i k x): that of the columns, turned on from row to row.
void Demodulator::start(Band& band) const {
  const auto turn = [](double cycles) {
    return std::polar(1.0F,
                      static_cast<float>(2 * std::numbers::pi * (cycles - std::rint(cycles))));
  };
  std::vector<std::complex<float>> along(static_cast<std::size_t>(frame_.width()));
  for (std::size_t i = 0; i < along.size(); ++i) {
    along[i] = turn(band.carrier.right * static_cast<double>(i));
  }
  for_each_row(frame_.height(), [&](int row) {
    const std::complex<float> down = turn(band.carrier.down * row);
    for (int column = 0; column < frame_.width(); ++column) {
      const std::complex<float> at = along[static_cast<std::size_t>(column)];
      band.cosine(column, row) = at.real() * down.real() - at.imag() * down.imag();
      band.sine(column, row) = at.real() * down.imag() + at.imag() * down.real();
    }
  });
}

/// C and S by what is near the phase that they have.
void Demodulator::take_near(Band& band) {
  for_each_row(varying_.height(), [&](int row) {
    const float* const v = varying_.row(row);
    float *const c = band.cosine.row(row), *const s = band.sine.row(row);
    float *const C = near_cosine_.row(row), *const S = near_sine_.row(row);
    for (int column = 0; column < varying_.width(); ++column) {
      const float norm = 1 / (std::sqrt(c[column] * c[column] + s[column] * s[column]) + smallest);
      c[column] *= norm;
      s[column] *= norm;
      C[column] = 2 * v[column] * c[column];
      S[column] = 2 * v[column] * s[column];
    }
  });
  take_moving_mean(near_cosine_, band.window, scratch_);
  take_moving_mean(near_sine_, band.window, scratch_);
  for_each_row(varying_.height(), [&](int row) {
    float *const c = band.cosine.row(row), *const s = band.sine.row(row);
    const float *const C = near_cosine_.row(row), *const S = near_sine_.row(row);
    for (int column = 0; column < varying_.width(); ++column) {
      const float turned = C[column] * s[column] - S[column] * c[column];
      c[column] = C[column] * c[column] + S[column] * s[column];
      s[column] = turned;
    }
  });
}

void Demodulator::leave_out_unexplained() {
  constexpr float most = 0.2F;
  Size window{1, 1};
  for (const Band& band : bands_) {
    window = {std::max(window.width, band.window.width),
              std::max(window.height, band.window.height)};
  }
  const Size size = varying_.size();
  Image<float>&unexplained = varying_, &explained = near_cosine_;
  for_each_pixel(size, [&](int column, int row) {
    float rest = varying_(column, row), squares = 0;
    for (const Band& band : bands_) {
      const float C = band.cosine(column, row), S = band.sine(column, row);
      rest -= C;
      squares += C * C + S * S;
    }
    unexplained(column, row) = rest * rest;
    explained(column, row) = squares;
  });
  take_moving_mean(unexplained, window, scratch_);
  for (Band& band : bands_) {
    for_each_pixel(size, [&](int column, int row) {
      if (unexplained(column, row) <= most * most * explained(column, row)) return;
      band.cosine(column, row) = band.sine(column, row) = 0;
    });
  }
}

void Demodulator::write(const SpectralFrame& frame, const Band& band,
                        Image<std::uint16_t>& image) const {
  using Kind = SpectralFrame::Kind;
  constexpr float saturated = 65535;
  const auto gain = static_cast<float>(1 / frame.share);
  const auto c = static_cast<float>(std::cos(frame.angle)),
             s = static_cast<float>(std::sin(frame.angle));
  for_each_row(image.height(), [&](int row) {
    for (int column = 0; column < image.width(); ++column) {
      const float C = band.cosine(column, row), S = band.sine(column, row);
      float level = mean_(column, row);
      if (frame.kind == Kind::sinusoid) level += gain / 2 * (c * C + s * S);
      if (frame.kind == Kind::envelope) level = gain * std::sqrt(C * C + S * S);
      level = std::clamp(levels * level + 0.5F, 0.0F, saturated - 1);
      image(column, row) =
          static_cast<std::uint16_t>(saturated_(column, row) != 0 ? saturated : level);
    }
  });
}

FrameSet demodulated(const Demodulation& how, Axis axis, const FrameViews& shown) {
  Demodulator demodulator(how, axis);
  demodulator(shown);
  return std::move(demodulator).frames();
}

}  // namespace slipstream
