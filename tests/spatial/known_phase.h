#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// A phase whose whole periods are known, rad, NaN where there is none.
struct KnownPhase {
  Image<float> truth;    ///< with the noise
  Image<float> wrapped;  ///< -pi to pi
};

/// `surface` gives the phase at a place, in pixels, NaN for none.
inline KnownPhase known_phase(Size size, double noise,
                              const std::function<double(double x, double y)>& surface) {
  KnownPhase known{Image<float>(size), Image<float>(size)};
  std::mt19937 random(2010);
  std::normal_distribution<double> normal;
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double phase = surface(column, row) + noise * normal(random);
      known.truth(column, row) = static_cast<float>(phase);
      known.wrapped(column, row) = static_cast<float>(std::remainder(phase, 2 * std::numbers::pi));
    }
  }
  return known;
}

/// Hills of slopes up to 0.3 rad per pixel, whatever the size.
inline double hills(Size size, double x, double y) {
  const double u = x / size.width, v = y / size.height, high = size.width / 16.;
  const auto hill = [&](double at_u, double at_v, double wide) {
    return std::exp(-((u - at_u) * (u - at_u) + (v - at_v) * (v - at_v)) / (wide * wide));
  };
  return high * (hill(0.35, 0.4, 0.25) - 0.7 * hill(0.7, 0.65, 0.2) + 0.5 * u);
}

struct NamedPhase {
  std::string name;
  std::function<KnownPhase(Size)> make;
};

/// What the table of docs/how-to/unwrap-phase-maps.md is of.
inline std::vector<NamedPhase> known_phases() {
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  std::vector<NamedPhase> all;
  for (const double noise : {0., 0.1, 0.3, 0.5, 0.7, 1.}) {
    all.push_back(
        {noise == 0 ? "hills" : "noise " + std::to_string(noise).substr(0, 3), [=](Size size) {
           return known_phase(size, noise, [&](double x, double y) { return hills(size, x, y); });
         }});
  }
  all.push_back({"residues", [](Size size) {  // one pixel of 100 says nothing
                   std::mt19937 random(7);
                   return known_phase(size, 0.1, [&](double x, double y) {
                     const double speckle =
                         random() % 100 == 0 ? 0.01 * static_cast<int>(random() % 628) : 0;
                     return hills(size, x, y) + speckle;
                   });
                 }});
  all.push_back({"holes", [=](Size size) {  // and a gap that keeps two regions apart
                   return known_phase(size, 0.3, [&](double x, double y) {
                     const double cell = size.width / 12.;
                     const double u = std::remainder(x, cell) / cell,
                                  v = std::remainder(y, cell) / cell;
                     const bool gap = std::abs(x - 0.8 * size.width + 0.2 * y) < 2;
                     return gap || u * u + v * v < 0.07 ? nothing : hills(size, x, y);
                   });
                 }});
  all.push_back({"step", [](Size size) {  // a ramp that ends in a cliff of 1.5 periods
                   return known_phase(size, 0.1, [&](double x, double y) {
                     const double u = x / size.width, v = y / size.height;
                     const bool ramp = u > 0.3 && u < 0.7 && v > 0.3 && v < 0.7;
                     return hills(size, x, y) + (ramp ? 3 * std::numbers::pi * (u - 0.3) / 0.4 : 0);
                   });
                 }});
  all.push_back({"shear", [](Size size) {  // two planes that meet in one point
                   return known_phase(size, 0.1, [&](double x, double y) {
                     const double from = x - 0.5 * size.width;
                     return (y < 0.5 * size.height ? 0.1 : -0.06) * from + 0.05 * y;
                   });
                 }});
  return all;
}

/// The connected region of each pixel that has a phase, -1 where it has none.
inline Image<int> regions_of(const Image<float>& phase) {
  Image<int> region(phase.size(), -1);
  std::vector<int> open;
  const int width = phase.width();
  for (int seed = 0; seed < static_cast<int>(phase.pixel_count()); ++seed) {
    const auto enter = [&](int at) {
      if (std::isnan(phase.begin()[at]) || region.begin()[at] >= 0) return;
      region.begin()[at] = seed;
      open.push_back(at);
    };
    for (enter(seed); !open.empty();) {
      const int at = open.back(), column = at % width;
      open.pop_back();
      if (column > 0) enter(at - 1);
      if (column + 1 < width) enter(at + 1);
      if (at >= width) enter(at - width);
      if (at + width < static_cast<int>(phase.pixel_count())) enter(at + width);
    }
  }
  return region;
}

/// The share of the pixels with a phase that are in the same whole period as in truth, up to one
/// constant for each connected region of the picture, whatever regions the unwrapping has.
template <class Number>
double right_share(const KnownPhase& known, const Image<Number>& unwrapped) {
  const Image<int> region = regions_of(known.truth);
  std::map<std::pair<int, long>, std::size_t> counts;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < region.pixel_count(); ++i) {
    if (region.begin()[i] < 0) continue;
    const double off = unwrapped.begin()[i] - known.truth.begin()[i];
    ++counts[{region.begin()[i], std::lround(off / (2 * std::numbers::pi))}];
    ++pixels;
  }
  std::map<int, std::size_t> most;
  for (const auto& [key, count] : counts) most[key.first] = std::max(most[key.first], count);
  std::size_t right = 0;
  for (const auto& [of, count] : most) right += count;
  return pixels == 0 ? 1 : static_cast<double>(right) / static_cast<double>(pixels);
}

}  // namespace slipstream
