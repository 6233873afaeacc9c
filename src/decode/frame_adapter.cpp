#include "decode/frame_adapter.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <type_traits>
#include <vector>

#include "base/moving_mean.h"
#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "decode/carrier.h"
#include "decode/located_pixels.h"
#include "decode/neighbours.h"
#include "frames/cycle_alignment.h"
#include "frames/pattern_windows.h"

namespace slipstream {
namespace {

/// The runs of steps that identify a cycle's first frame, from fewest periods to most; empty unless
/// the layout consists of two or more runs.
std::vector<CycleRun> cycle_runs(const Layout& layout) {
  std::vector<CycleRun> runs;
  int covered = 0;
  for (const std::size_t i : coarse_to_fine(layout)) {
    const auto run = step_run(layout.bands[i]);
    if (!run) break;

    covered += run->steps;
    const Band steps = phase_shifted_band(run->steps, 0, run->steps, 1);
    runs.push_back({run->first, steps.cosine, steps.sine});
  }

  if (runs.size() < 2 || covered != layout.frames) runs.clear();
  return runs;
}

constexpr float levels = 257;      // 16-bit levels per 8-bit level
constexpr float smallest = 1e-9F;  // avoids division by zero

template <class Pixel>
void resize(Image<Pixel>& image, Size size) {
  if (image.size() != size) image = Image<Pixel>(size);
}

/// exp(i k x) at x = 0, 1, ...
struct Wave {
  Wave(double cycles, int length) : cosine(static_cast<std::size_t>(length)), sine(cosine.size()) {
    for (std::size_t i = 0; i < cosine.size(); ++i) {
      const double turns = cycles * static_cast<double>(i);
      const double angle = two_pi * (turns - std::rint(turns));
      cosine[i] = static_cast<float>(std::cos(angle));
      sine[i] = static_cast<float>(std::sin(angle));
    }
  }

  std::vector<float> cosine, sine;
};

double distance(const Carrier& a, const Carrier& b) {
  return std::hypot(a.right - b.right, a.down - b.down);
}

}  // namespace

FrameAdapter::FrameAdapter(const Sequence& sequence) : read_(sequence.strategy.layout().frames) {
  if (sequence.exposures.size() > 1) exposures_ = sequence.exposures;
  if (const auto how = sequence.strategy.demodulation()) demodulate_.emplace(*how, sequence.axis);
}

const FrameViews& FrameAdapter::operator()(const FrameViews& taken) {
  if (demodulate_ && taken.count() != read_) return (*demodulate_)(taken);
  if (exposures_.empty() || taken.merged()) return taken;
  merge_exposures(taken, exposures_, merged_);
  return merged_.views;
}

std::vector<FrameSet> adapted(const Sequence& sequence, FrameSet taken) {
  if (sequence.exposures.size() > 1) taken = merged_exposures(taken, sequence.exposures);

  // With patterns along both axes the second scan has the other one.
  std::vector<FrameSet> scans;
  if (sequence.both_axes) {
    const std::vector<int> counts = frames_along_axes(sequence);
    const int wanted = std::accumulate(counts.begin(), counts.end(), 0);
    throw_if(taken.count() < wanted, "{} frames are too few; the patterns along both axes are {}",
             taken.count(), wanted);

    scans = parts_of(std::move(taken), counts);
  } else {
    scans.push_back(std::move(taken));
  }

  Axis axis = sequence.axis;
  for (FrameSet& frames : scans) {
    if (const auto how = along(sequence, axis).strategy.demodulation()) {
      frames = demodulated(*how, axis, frames);
    }
    axis = across(axis);
  }

  return scans;
}

PatternCycle pattern_cycle(const Sequence& sequence, int scans) {
  return {.patterns = scans * frame_count(cycle_of(sequence)),
          .extra = sequence.motion,
          .runs = scans == 1 ? cycle_runs(sequence.strategy.layout()) : std::vector<CycleRun>{}};
}

Demodulator::Demodulator(Demodulation how, Axis axis) : how_(std::move(how)), axis_(axis) {
  // Frames of one carrier share its band.
  for (const SpectralFrame& frame : how_.frames) {
    const auto known = std::ranges::find_if(bands_, [&](const Band& band) {
      return frame.periods == band.periods && frame.across == band.across;
    });
    band_of_.push_back(static_cast<std::size_t>(known - bands_.begin()));
    if (known == bands_.end()) bands_.push_back({frame.periods, frame.across});
  }

  images_.resize(how_.frames.size());
  aligned_ = std::ranges::none_of(bands_, &Band::across);
}

const FrameViews& Demodulator::operator()(const FrameViews& shown) {
  throw_if(shown.count() != how_.shown, "{} frames given; expected {}", shown.count(), how_.shown);

  take(shown);
  if (how_.grid.columns > 0) {
    locate(shown);
  } else {
    // 1. A first pass: the mean, and each carrier near its place in the spectrum.
    find_carriers();
    const int square = odd_length(aligned_ ? longest_ / 2 : longest_);
    take_mean(aligned_ ? widest_ : Size{square, square}, false);
    for (Band& band : bands_) take_near(band, false);

    // 2. A second pass around the phase just found, and the mean of the residual.
    if (aligned_) take_mean({square, square}, true);
    for (Band& band : bands_) take_near(band, true);

    square_residual();
  }

  write();
  views_.assign<std::uint16_t>(images_, 16);
  return views_;
}

/// Sets the carriers from the positions that the grid gives.
void Demodulator::locate(const FrameViews& shown) {
  const Size size = shown.size();
  saturated_ = saturation_mask(shown);
  const auto grey = static_cast<float>(255 / shown.full_scale());

  // 1. Frames in 8-bit grey levels, and their mean over a few symbols.
  std::vector<Image<float>> frames(static_cast<std::size_t>(shown.count()), Image<float>(size));
  shown.visit([&](const auto& views) {
    const float share = 1 / static_cast<float>(views.size());
    for_each_row(size.height, [&](int row) {
      std::fill_n(mean_.row(row), size.width, 0.0F);
      for (std::size_t n = 0; n < views.size(); ++n) {
        for (int column = 0; column < size.width; ++column) {
          frames[n](column, row) = grey * static_cast<float>(views[n](column, row));
          mean_(column, row) += share * frames[n](column, row);
        }
      }
    });
  });

  constexpr double symbols = 4;  // averaged over
  const int window = odd_length(symbols * length_along(axis_, size) / how_.grid.columns);
  take_moving_mean(mean_, {window, window}, scratch_);

  // 2. The field's coordinate from stripes or symbols.
  const LocatedPixels at = located_by_neighbours(how_.grid, axis_, std::move(frames));

  // 3. The carriers' phases from the coordinate.
  for_each_row(size.height, [&](int row) {
    std::fill_n(near_cosine_.row(row), size.width, 0.0F);  // residual: none
    std::fill_n(near_sine_.row(row), size.width, 0.0F);
    for (int column = 0; column < size.width; ++column) {
      const float y = at.coordinate(column, row);
      const float B = at.modulation(column, row);

      mean_(column, row) = std::max(mean_(column, row), B);  // symbols have more dark than lit area

      for (Band& band : bands_) {
        const double turns = band.periods * static_cast<double>(y);
        const auto angle = static_cast<float>(two_pi * (turns - std::rint(turns)));
        const bool known = !std::isnan(y);
        band.cosine(column, row) = known ? B * std::cos(angle) : 0;
        band.sine(column, row) = known ? B * std::sin(angle) : 0;
      }
    }
  });
}

void Demodulator::take(const FrameViews& shown) {
  const Size size = shown.size();
  for (Image<float>* const image : {&frame_, &mean_, &near_cosine_, &near_sine_}) {
    resize(*image, size);
  }

  for (Band& band : bands_) {
    resize(band.cosine, size);
    resize(band.sine, size);
  }

  for (Image<std::uint16_t>& image : images_) resize(image, size);
  resize(saturated_, size);

  // Two frames with opposite carriers: half the difference has the carriers, half the sum the mean.
  const auto grey = static_cast<float>(255 / shown.full_scale());
  shown.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
    const auto full = std::is_integral_v<Pixel> ? static_cast<float>(shown.saturation())
                                                : std::numeric_limits<float>::infinity();

    for_each_row(size.height, [&](int row) {
      const Pixel *const first = frames.front().row(row), *const second = frames.back().row(row);
      float *const frame = frame_.row(row), *const mean = mean_.row(row);

      std::uint8_t* const saturated = saturated_.row(row);
      const bool two = how_.shown == 2;

      for (int column = 0; column < size.width; ++column) {
        const auto I = static_cast<float>(first[column]), J = static_cast<float>(second[column]);
        frame[column] = grey * (two ? (I - J) / 2 : I);
        if (two) mean[column] = grey * (I + J) / 2;
        saturated[column] = static_cast<std::uint8_t>(std::max(I, J) >= full ? 1 : 0);
      }
    });
  });
}

void Demodulator::find_carriers() {
  // 1. Carriers along the axis, then those across it, each by their common scale.
  for (const bool across : {false, true}) {
    std::vector<double> periods;
    std::vector<Band*> of;
    for (Band& band : bands_) {
      if (band.across != across) continue;
      periods.push_back(band.periods);
      of.push_back(&band);
    }
    if (periods.empty()) continue;

    const auto found = found_carriers(frame_, periods, (axis_ == Axis::x) != across);
    for (std::size_t i = 0; i < of.size(); ++i) of[i]->carrier = found[i];
  }

  // 2. A window over a period of the nearest frequency to remove: the mean, another carrier or its
  // mirror image.
  longest_ = 1;
  widest_ = {1, 1};
  for (Band& band : bands_) {
    const Carrier k = band.carrier;
    double nearest = distance(k, {});
    longest_ = std::max(longest_, 1 / nearest);

    for (const Band& other : bands_) {
      if (&other == &band) continue;
      nearest = std::min({nearest, distance(k, other.carrier),
                          distance(k, {-other.carrier.right, -other.carrier.down})});
    }

    // Across, a quarter of it is enough if all carriers run the same way.
    const int along = odd_length(1 / nearest), across = odd_length((aligned_ ? 0.25 : 1) / nearest);
    band.window = std::abs(k.right) > std::abs(k.down) ? Size{along, across} : Size{across, along};

    widest_ = {std::max(widest_.width, band.window.width),
               std::max(widest_.height, band.window.height)};
  }
}

/// For a single frame: the mean of the residual without the carriers.
void Demodulator::take_mean(Size window, bool started) {
  if (how_.shown == 2) return;

  for_each_row(frame_.height(), [&](int row) {
    float* const mean = mean_.row(row);
    std::copy_n(frame_.row(row), frame_.width(), mean);

    if (!started) return;
    for (const Band& band : bands_) {
      const float* const C = band.cosine.row(row);
      for (int column = 0; column < frame_.width(); ++column) mean[column] -= C[column];
    }
  });

  take_moving_mean(mean_, window, scratch_);
}

/// C and S from the surroundings of their current phase; initially of the carrier, exp(i k x).
void Demodulator::take_near(Band& band, bool started) {
  const auto [width, height] = frame_.size();
  const float of_mean = how_.shown == 2 ? 0 : 1;

  const Wave along(started ? 0 : band.carrier.right, width),
      down(started ? 0 : band.carrier.down, height);

  // 1. The frame's variation times the unit wave: that moves the carrier to frequency 0.
  for_each_row(height, [&](int row) {
    const float *const I = frame_.row(row), *const A = mean_.row(row);
    float *const c = band.cosine.row(row), *const s = band.sine.row(row);
    float *const C = near_cosine_.row(row), *const S = near_sine_.row(row);

    const float *const right = along.cosine.data(), *const right_sine = along.sine.data();
    const float turn = down.cosine[row], turn_sine = down.sine[row];

    // The carrier as a wave over the picture: the product of one along rows and one down columns.
    for (int column = 0; column < width && !started; ++column) {
      c[column] = right[column] * turn - right_sine[column] * turn_sine;
      s[column] = right[column] * turn_sine + right_sine[column] * turn;
    }

    for (int column = 0; column < width; ++column) {
      const float v = I[column] - of_mean * A[column];
      const float norm = 1 / (std::sqrt(c[column] * c[column] + s[column] * s[column]) + smallest);

      c[column] *= norm;
      s[column] *= norm;
      C[column] = 2 * v * c[column];
      S[column] = 2 * v * s[column];
    }
  });

  // 2. The low-pass filter keeps this carrier alone.
  take_moving_mean(near_cosine_, band.window, scratch_);
  take_moving_mean(near_sine_, band.window, scratch_);

  // 3. Turn back: C + i S of the carrier itself.
  for_each_row(height, [&](int row) {
    float *const c = band.cosine.row(row), *const s = band.sine.row(row);
    const float *const C = near_cosine_.row(row), *const S = near_sine_.row(row);
    for (int column = 0; column < width; ++column) {
      const float turned = C[column] * s[column] - S[column] * c[column];
      c[column] = C[column] * c[column] + S[column] * s[column];
      s[column] = turned;
    }
  });
}

/// Mean squares of the residual, in near_sine_, and squares of the carriers, in near_cosine_.
void Demodulator::square_residual() {
  const float of_mean = how_.shown == 2 ? 0 : 1;

  for_each_row(frame_.height(), [&](int row) {
    const float *const I = frame_.row(row), *const A = mean_.row(row);
    float *const rest = near_sine_.row(row), *const squares = near_cosine_.row(row);
    for (int column = 0; column < frame_.width(); ++column) {
      rest[column] = I[column] - of_mean * A[column];
      squares[column] = 0;
    }

    for (const Band& band : bands_) {
      const float *const C = band.cosine.row(row), *const S = band.sine.row(row);
      for (int column = 0; column < frame_.width(); ++column) {
        rest[column] -= C[column];
        squares[column] += C[column] * C[column] + S[column] * S[column];
      }
    }

    for (int column = 0; column < frame_.width(); ++column) rest[column] *= rest[column];
  });

  take_moving_mean(near_sine_, widest_, scratch_);
}

/// Writes the carriers as frames; without carriers where the residual is too large.
void Demodulator::write() {
  using Kind = SpectralFrame::Kind;
  constexpr float most = 0.2F, saturated = 65535;

  const int width = frame_.width();
  for_each_row(frame_.height(), [&](int row) {
    float *const rest = near_sine_.row(row), *const mean = mean_.row(row);
    const float* const squares = near_cosine_.row(row);
    const std::uint8_t* const full = saturated_.row(row);

    // 1 where the carriers explain the frame, else 0.
    for (int column = 0; column < width; ++column) {
      rest[column] = rest[column] <= most * most * squares[column] ? 1.0F : 0.0F;
    }
    for (std::size_t n = 0; n < images_.size(); ++n) {
      const SpectralFrame& frame = how_.frames[n];
      const Band& band = bands_[band_of_[n]];
      const float *const C = band.cosine.row(row), *const S = band.sine.row(row);

      const auto gain = static_cast<float>(levels / frame.share);
      const bool envelope = frame.kind == Kind::envelope;
      // Weights of mean, strength and wave by the kind of frame.
      const float of_mean = envelope ? 0 : levels, of_strength = envelope ? gain : 0;
      const float of_wave = frame.kind == Kind::sinusoid ? gain / 2 : 0;
      const auto c = of_wave * static_cast<float>(std::cos(frame.angle)),
                 s = of_wave * static_cast<float>(std::sin(frame.angle));

      std::uint16_t* const image = images_[n].row(row);
      for (int column = 0; column < width; ++column) {
        const float strength = std::sqrt(C[column] * C[column] + S[column] * S[column]);
        const float level =
            of_mean * mean[column] +
            rest[column] * (of_strength * strength + c * C[column] + s * S[column]) + 0.5F;

        const float shown = std::min(std::max(level, 0.0F), saturated - 1);
        image[column] = static_cast<std::uint16_t>(
            static_cast<std::int32_t>(full[column] != 0 ? saturated : shown));
      }
    }
  });
}

FrameSet demodulated(const Demodulation& how, Axis axis, const FrameViews& shown) {
  Demodulator demodulator(how, axis);
  demodulator(shown);
  return std::move(demodulator).frames();
}

}  // namespace slipstream
