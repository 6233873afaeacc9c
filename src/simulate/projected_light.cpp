#include "simulate/projected_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "simulate/frame_rows.h"
#include "simulate/seen_scene.h"

namespace slipstream {
namespace {

using Profile = std::vector<double>;

constexpr int places = 8;          // samples of a profile per projector pixel
constexpr double blur_step = 0.5;  // pixels, between profiles

/// The unblurred profile across the projector.
Profile sharp_profile(const PatternSet& patterns, int n, int length, const Photometry& photometry) {
  Profile profile;
  for (int place = 0; place < length * places; ++place) {
    // Exact light, or light that is constant over each pixel and set at its centre.
    if (!photometry.physics.projector_pixels) {
      const double pixel = (place + 0.5) / places - 0.5;
      profile.push_back(responded(patterns.intensity(n, pixel / length), photometry));
    } else if (place % places > 0) {
      profile.push_back(profile.back());
    } else {
      const double y = static_cast<double>(place / places) / length;  // at the pixel's centre
      profile.push_back(responded(std::round(patterns.intensity(n, y)), photometry));
    }
  }

  return profile;
}

/// `deviation`: in places, above 0. Dark beyond the ends.
Profile blurred(const Profile& sharp, double deviation) {
  const int reach = static_cast<int>(std::ceil(4 * deviation));

  Profile weights;
  for (int i = -reach; i <= reach; ++i) {
    weights.push_back(std::exp(-0.5 * i * i / (deviation * deviation)));
  }
  const double all = std::accumulate(weights.begin(), weights.end(), 0.0);

  // The profile shifted by each distance, where both overlap.
  Profile result(sharp.size(), 0);
  const int size = static_cast<int>(sharp.size());
  for (int i = std::max(-reach, 1 - size); i <= std::min(reach, size - 1); ++i) {
    const std::span<const double> from(sharp.begin() + std::max(i, 0),
                                       sharp.end() + std::min(i, 0));
    add_scaled(from, weights[i + reach] / all, result.data() + std::max(-i, 0));
  }

  return result;
}

/// Profiles of one pattern from sharp to the widest blur.
BlurredProfiles blurred_profiles(const Profile& sharp, double widest) {
  BlurredProfiles profiles{.samples = sharp,
                           .size = static_cast<int>(sharp.size()),
                           .steps = 1,
                           .places = places,
                           .blur_step = blur_step};
  for (; (profiles.steps - 1) * blur_step < widest; ++profiles.steps) {
    const Profile next = blurred(sharp, profiles.steps * blur_step * places);
    profiles.samples.insert(profiles.samples.end(), next.begin(), next.end());
  }

  return profiles;
}

/// Share of a Gaussian over each pixel of a row, from pixel `first` on.
struct PixelShares {
  int first = 0;
  std::vector<double> shares{};
};

PixelShares shares_about(double place, double deviation, int length) {
  if (deviation == 0) return {std::clamp(static_cast<int>(std::lround(place)), 0, length - 1), {1}};

  // The Gaussian's integral over each pixel, to four standard deviations on both sides.
  const int first = std::max(static_cast<int>(std::lround(place - 4 * deviation)), 0);
  const int last = std::min(static_cast<int>(std::lround(place + 4 * deviation)), length - 1);

  const auto up_to = [&](double edge) {
    return std::erf((edge - place) / (std::numbers::sqrt2 * deviation)) / 2;
  };

  PixelShares result{.first = first};
  for (double i = first, before = up_to(first - 0.5); i <= last; ++i) {
    const double after = up_to(i + 0.5);
    result.shares.push_back(after - before);
    before = after;
  }

  return result;
}

/// Blurred picture at a position, constant over each pixel; dark beyond its edges.
double blurred_at(const Image<double>& picture, const Eigen::Vector2d& place, double deviation) {
  const PixelShares across = shares_about(place.x(), deviation, picture.width());
  const PixelShares down = shares_about(place.y(), deviation, picture.height());
  double sum = 0;

  for (std::size_t i = 0; i < down.shares.size(); ++i) {
    const double* const row = picture.row(down.first + static_cast<int>(i)) + across.first;
    sum +=
        down.shares[i] * std::inner_product(across.shares.begin(), across.shares.end(), row, 0.0);
  }

  return sum;
}

/// `light_under`: the light under a given blur.
template <class LightUnder>
double spread_light(const LitSample& sample, const LightUnder& light_under) {
  const double sharp = light_under(sample.blur);
  if (sample.spread == 0) return sharp;
  return (sharp + light_under(std::hypot(sample.blur, sample.spread))) / 2;
}

}  // namespace

double responded(double intensity, const Photometry& photometry) {
  if (is_linear(photometry.response)) return intensity;
  return 255 * light_at(photometry.response, intensity / 255);  // (4.2)
}

ProjectedLight light_of_picture(const Image<std::uint8_t>& picture, const Photometry& photometry) {
  std::array<double, 256> light_of{};
  for (std::size_t level = 0; level < light_of.size(); ++level) {
    light_of[level] = responded(static_cast<double>(level), photometry);
  }

  Image<double> light(picture.size());
  std::ranges::transform(picture, light.begin(),
                         [&](std::uint8_t level) { return light_of[level]; });

  return [light = std::move(light)](const LitSample& sample) {
    return spread_light(sample, [&](double blur) { return blurred_at(light, sample.pixel, blur); });
  };
}

ProjectedLight projected_light(const PatternSet& patterns, int n, Size projector,
                               const Photometry& photometry, const SeenScene& seen) {
  const Axis axis = patterns.axis_of(n);

  // The widest blur of any sample says how many blurred profiles are needed.
  const double widest = *std::ranges::max_element(seen.widest);

  // Patterns of pixels, and blurred ones that vary in both directions, need the whole picture.
  const bool exact = !photometry.physics.projector_pixels && widest == 0;
  if (patterns.binary || (patterns.carrier && !exact)) {
    return light_of_picture(in_8_bits(render_pattern(patterns, n, projector)), photometry);
  }

  // Without blur and pixels, the light of a sample's exact position.
  if (exact) {
    return [=](const LitSample& sample) {
      const double y = coordinate_along(axis, sample.pixel, projector);
      const double x = coordinate_along(across(axis), sample.pixel, projector);
      return responded(patterns.intensity(n, y, x), photometry);
    };
  }

  // Otherwise a profile along the axis is enough, blurred in steps.
  const int length = length_along(axis, projector);
  BlurredProfiles profiles =
      blurred_profiles(sharp_profile(patterns, n, length, photometry), widest);
  profiles.along_columns = axis == Axis::x;

  return [profiles = std::move(profiles)](std::span<const LitSample> samples, double* light) {
    light_of(profiles, samples, light);
  };
}

}  // namespace slipstream
