#include "frames/colour_channels.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "frames/scan_camera.h"

namespace slipstream {
namespace {

using Mixture = Eigen::Map<const Eigen::Matrix<double, colour_channels, 4, Eigen::RowMajor>>;

Eigen::Matrix3d colours_of(const ColourMixture& mixture) {
  return Mixture(mixture.front().data()).leftCols<colour_channels>();
}

/// Mean of each frame over the lit pixels, grey levels of 255.
template <class Pixel>
std::vector<double> lit_means(const Frames<Pixel>& frames, double grey_level) {
  const Size size = frames.front().size();

  // The largest rise of any channel over the black picture, which comes first.
  const auto gain = [&](int column, int row) {
    double most = 0;
    for (std::size_t n = colour_channels; n < frames.size(); ++n) {
      most = std::max(most, static_cast<double>(frames[n](column, row)) -
                                static_cast<double>(frames[n % colour_channels](column, row)));
    }
    return most;
  };

  double brightest = 0;
  for_each_pixel_in_order(
      size, [&](int column, int row) { brightest = std::max(brightest, gain(column, row)); });

  std::vector<double> sums(frames.size());
  std::size_t count = 0;
  for_each_pixel_in_order(size, [&](int column, int row) {
    if (brightest == 0 || gain(column, row) < 0.1 * brightest) return;
    ++count;
    for (std::size_t n = 0; n < frames.size(); ++n) {
      sums[n] += static_cast<double>(frames[n](column, row)) / grey_level;
    }
  });

  for (double& sum : sums) sum /= static_cast<double>(std::max<std::size_t>(count, 1));
  return sums;
}

FrameFormat format_of(const FrameSource& pictures) {
  const FrameFormat format = pictures.format();
  throw_if(format.bits != 8 || format.size.width % colour_channels != 0,
           "colour pictures must have three 8-bit values per pixel");
  return {{format.size.width / colour_channels, format.size.height}, 8};
}

Eigen::Vector3f dark_of(const ColourMixture& mixture) {
  return Mixture(mixture.front().data()).col(3).cast<float>();
}

/// Grey levels of 255 in the three frames from `n` on.
template <class Pixel>
Eigen::Vector3f seen_at(const Frames<Pixel>& frames, std::size_t n, int column, int row,
                        float grey) {
  return grey * Eigen::Vector3f(static_cast<float>(frames[n](column, row)),
                                static_cast<float>(frames[n + 1](column, row)),
                                static_cast<float>(frames[n + 2](column, row)));
}

using Gains = std::array<float, colour_channels>;

/// Gain per channel that makes a painted surface look grey: NaN where the white picture is dark,
/// infinite where it is saturated; empty without a white picture.
Image<Gains> whitening(const ColourMixture& mixture, const FrameViews& white) {
  if (white.count() == 0) return {};

  constexpr float least = 8;  // grey levels
  const Eigen::Vector3f sums = colours_of(mixture).rowwise().sum().cast<float>();
  const Eigen::Vector3f dark = dark_of(mixture);

  const Image<std::uint8_t> saturated = saturation_mask(white);
  const auto grey = static_cast<float>(255 / white.full_scale());

  Image<Gains> gains(white.size());
  white.visit([&](const auto& views) {
    for_each_pixel(white.size(), [&](int column, int row) {
      // The share of the light that each channel keeps, and gains that make all three equal.
      const Eigen::Vector3f light = seen_at(views, 0, column, row, grey) - dark;
      const Eigen::Vector3f kept = light.cwiseQuotient(sums);
      Eigen::Map<Eigen::Vector3f> gain(gains(column, row).data());
      gain = kept.mean() * kept.cwiseInverse();

      if (light.minCoeff() < least) gain.setConstant(std::numeric_limits<float>::quiet_NaN());
      if (saturated(column, row) != 0) gain.setConstant(std::numeric_limits<float>::infinity());
    });
  });

  return gains;
}

}  // namespace

void require_valid(const ColourMixture& mixture) {
  const Eigen::Matrix3d colours = colours_of(mixture);

  // Condition number: the largest factor by which noise grows.
  constexpr double worst = 50;
  const double condition =
      colours.cwiseAbs().maxCoeff() * colours.inverse().cwiseAbs().rowwise().sum().maxCoeff();

  throw_if(!Mixture(mixture.front().data()).allFinite() || !(condition <= worst),
           "colour_mixture: the camera's channels cannot separate the projector's colours");
}

ColourMixture measured_mixture(const FrameViews& pictures) {
  constexpr int wanted = 4 * colour_channels;
  throw_if(pictures.count() != wanted,
           "{} frames given; expected {}: three channels each of black, red, green and blue",
           pictures.count(), wanted);

  // 1. Mean of each channel over the lit surface.
  const Image<std::uint8_t> saturated = saturation_mask(pictures);
  const auto clipped = std::count(saturated.begin(), saturated.end(), 1);
  throw_if(20 * clipped > static_cast<std::ptrdiff_t>(saturated.pixel_count()),
           "more than 5 % of the pixels are saturated; use a shorter exposure");

  const std::vector<double> means = pictures.visit(
      [&](const auto& frames) { return lit_means(frames, pictures.full_scale() / 255); });

  // 2. Columns: the three colours without black, then black.
  ColourMixture mixture{};
  double diagonal = 0;
  for (std::size_t c = 0; c < colour_channels; ++c) {
    for (std::size_t p = 0; p < colour_channels; ++p) {
      mixture[c][p] = means[colour_channels * (p + 1) + c] - means[c];
    }
    mixture[c][colour_channels] = means[c];
    diagonal += mixture[c][c] / colour_channels;
  }

  throw_if(!(diagonal > 1), "the pictures show no light of the projector's three colours");
  // Scale to a mean diagonal of 1.
  for (auto& row : mixture) {
    for (std::size_t p = 0; p < colour_channels; ++p) row[p] /= diagonal;
  }

  require_valid(mixture);
  return mixture;
}

FrameSet unmixed(const FrameViews& frames, const ColourMixture& mixture, const FrameViews& white) {
  throw_if(frames.count() % colour_channels != 0,
           "{} frames given; expected a multiple of 3, one per channel", frames.count());
  throw_if(
      white.count() != 0 && (white.count() != colour_channels || white.size() != frames.size()),
      "the white picture must have three channels of the frames' size");
  require_valid(mixture);

  constexpr float levels = 257, brightest = 65535;  // for 16 bits
  const Eigen::Matrix3f inverse = colours_of(mixture).inverse().cast<float>();
  const Eigen::Vector3f dark = dark_of(mixture);
  const Image<Gains> gains = whitening(mixture, white);

  const auto grey = static_cast<float>(255 / frames.full_scale());
  const Size size = frames.size();

  FrameSet::Images16 alone(frames.count(), Image<std::uint16_t>(size));
  frames.visit([&](const auto& views) {
    for (std::size_t n = 0; n < views.size(); n += colour_channels) {
      const Image<std::uint8_t> saturated =
          saturation_mask(frames.part(static_cast<int>(n), colour_channels));

      for_each_pixel(size, [&](int column, int row) {
        const Gains white_gain = gains.empty() ? Gains{1, 1, 1} : gains(column, row);
        const Eigen::Vector3f seen = seen_at(views, n, column, row, grey) - dark;

        // Add the mean of the dark levels to all three: a common offset does not affect the phase.
        const Eigen::Vector3f light =
            (inverse * Eigen::Vector3f(white_gain.data()).cwiseProduct(seen)).array() + dark.mean();

        const bool is_saturated = saturated(column, row) != 0 || std::isinf(white_gain[0]);
        for (std::size_t p = 0; p < colour_channels; ++p) {
          const float level = levels * light[p] + 0.5F;
          alone[n + p](column, row) = static_cast<std::uint16_t>(
              is_saturated        ? brightest
              : std::isnan(level) ? 0
                                  : std::clamp(level, 0.0F, brightest - 1));
        }
      });
    }
  });

  return {std::move(alone), 16};
}

std::string doubt_about_colours(bool mixture_known, bool white_known) {
  if (!mixture_known) {
    return "colour pictures without a colour mixture: channels are not separated; measure it with "
           "`calibrate_colour()`";
  }
  return white_known
             ? ""
             : "colour pictures without a white picture: only uniformly grey surfaces are correct";
}

ColourSource::ColourSource(std::unique_ptr<FrameSource> pictures)
    : SourceOver(std::move(pictures)),
      format_(format_of(*source_)),
      picture_(source_->format()),
      returned_(colour_channels) {}

void ColourSource::start() {
  returned_ = colour_channels;
  source_->start();
}

Arrival ColourSource::next(Frame& frame, std::chrono::milliseconds timeout) {
  // A new picture once all channels of the last one are returned.
  if (returned_ == colour_channels) {
    const Arrival arrival = source_->next(picture_, timeout);
    if (arrival != Arrival::frame) return arrival;
    returned_ = 0;
  }

  // Its next channel, of every third value.
  if (frame.format() != format_) frame = Frame(format_);
  const std::uint8_t* value = std::get<Image<std::uint8_t>>(picture_.pixels).begin() + returned_;
  for (std::uint8_t& pixel : std::get<Image<std::uint8_t>>(frame.pixels)) {
    pixel = *value;
    value += colour_channels;
  }

  // Three frames, and patterns, for each picture.
  frame.stamp = picture_.stamp;
  frame.stamp.sequence = colour_channels * frame.stamp.sequence + returned_;
  if (std::optional<int>& pattern = frame.stamp.pattern_index) {
    *pattern = colour_channels * *pattern + returned_;
  }

  ++returned_;
  return Arrival::frame;
}

SourceCounters ColourSource::counters() const {
  SourceCounters counters = source_->counters();
  counters.delivered *= colour_channels;
  counters.lost *= colour_channels;
  return counters;
}

UnmixedSource::UnmixedSource(std::unique_ptr<FrameSource> source, const ColourMixture& mixture,
                             FrameSet white)
    : SourceOver(std::move(source)), mixture_(mixture), white_(std::move(white)) {}

void UnmixedSource::start() {
  seen_.clear();
  returned_ = stamps_.size();
  source_->start();
}

Arrival UnmixedSource::next(Frame& frame, std::chrono::milliseconds timeout) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + timeout;

  // 1. Wait for the three channels of one image, and separate its colours.
  while (returned_ == stamps_.size()) {
    Frame seen(source_->format());
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    const Arrival arrival = source_->next(seen, std::max(left, std::chrono::milliseconds(0)));
    if (arrival != Arrival::frame) return arrival;

    const std::uint64_t number = seen.stamp.sequence;
    if (!seen_.empty() && number != seen_.back().stamp.sequence + 1) seen_.clear();
    if (number % colour_channels != seen_.size()) continue;  // the image's first channel is missing

    seen_.push_back(std::move(seen));
    if (seen_.size() < colour_channels) continue;

    stamps_.clear();
    for (const Frame& channel : seen_) stamps_.push_back(channel.stamp);
    apart_ = unmixed(frame_set_of(std::exchange(seen_, {})), mixture_, white_);
    returned_ = 0;
  }

  // 2. Return its next frame.
  if (frame.format() != format()) frame = Frame(format());
  apart_.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
    if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
      auto& image = std::get<Image<std::uint16_t>>(frame.pixels);
      std::copy_n(frames[returned_].row(0), image.pixel_count(), image.begin());
    }
  });

  frame.stamp = stamps_[returned_++];
  return Arrival::frame;
}

}  // namespace slipstream
