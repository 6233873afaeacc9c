#include "check/map_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "base/statistics.h"

namespace slipstream {
namespace {

/// A pixel of the map beside an invalid one.
struct MapEdge {
  double coordinate = 0;  ///< of the invalid pixel, if it went on as before
  double step = 0;        ///< change towards it
};

/// The edges towards which the coordinate rises. The picture's own edges are none.
std::vector<MapEdge> rising_edges(const Image<double>& map) {
  const Size size = map.size();
  const auto at = [&](int column, int row) {
    const bool inside = column >= 0 && column < size.width && row >= 0 && row < size.height;
    return inside ? std::optional(map(column, row)) : std::nullopt;
  };

  constexpr std::array<std::pair<int, int>, 4> directions{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  std::vector<MapEdge> edges;
  for_each_pixel_in_order(size, [&](int column, int row) {
    const double here = map(column, row);
    if (!std::isfinite(here)) return;

    for (const auto& [right, down] : directions) {
      const auto next = at(column + right, row + down), before = at(column - right, row - down);
      if (!next || std::isfinite(*next) || !before) continue;

      const double step = here - *before;
      if (step > 0 && std::isfinite(step)) edges.push_back({here + step, step});
    }
  });
  return edges;
}

/// The coordinate at which most edges are, if they are enough and hardly a pixel lies beyond.
std::optional<LightEnd> rising_end(const Image<double>& map, std::size_t valid) {
  // Correct scans: 0.6 of the picture's shorter side; edges of objects up to 0.39.
  constexpr double least_length = 0.45;
  constexpr std::size_t fewest = 24;
  constexpr double most_beyond = 0.005;

  std::vector<MapEdge> edges = rising_edges(map);
  if (edges.size() < fewest) return std::nullopt;
  std::ranges::sort(edges, {}, &MapEdge::coordinate);

  std::vector<double> steps;
  for (const MapEdge& edge : edges) steps.push_back(edge.step);
  const double width = 1.5 * quantile(steps, 0.5);

  // 1. The interval of this width with the most edges.
  std::size_t first = 0, best = 0, count = 0;
  for (std::size_t last = 0; last < edges.size(); ++last) {
    while (edges[last].coordinate - edges[first].coordinate > width) ++first;
    if (last + 1 - first <= count) continue;
    count = last + 1 - first;
    best = first;
  }

  const int side = std::min(map.width(), map.height());
  if (static_cast<double>(count) < least_length * side || count < fewest) return std::nullopt;

  // 2. Its middle, and the step there.
  steps.clear();
  for (std::size_t i = best; i < best + count; ++i) steps.push_back(edges[i].step);
  const LightEnd end{edges[best + count / 2].coordinate, quantile(steps, 0.5)};

  // 3. Light ends there if hardly a pixel is lit beyond.
  const auto beyond = std::ranges::count_if(
      map, [&](double coordinate) { return coordinate > end.coordinate + 2 * end.step; });
  if (static_cast<double>(beyond) > most_beyond * static_cast<double>(valid)) return std::nullopt;
  return end;
}

/// Whether the coordinate changes by whole stripes, so that most neighbours are equal.
bool is_of_whole_stripes(std::span<const CoordinateSample> samples) {
  constexpr double most = 0.25;  // rounded coordinates of one pixel each: 0.2
  const auto equal = std::ranges::count_if(samples, [](const CoordinateSample& sample) {
    return sample.change && sample.change->coordinate.isZero(0);
  });
  return static_cast<double>(equal) > most * static_cast<double>(samples.size());
}

std::vector<CoordinateSample> spread_samples(const Image<double>& map) {
  constexpr int most_looked = 16384;
  constexpr std::size_t wanted = 1024;
  const Size size = map.size();
  // A surface goes on this far, as for ScanSamples.
  const int far = std::max(3, std::max(size.width, size.height) / 64);

  std::vector<CoordinateSample> samples;
  for (int i = 0; i < most_looked && samples.size() < wanted; ++i) {
    const auto [right, down] = spread_place(i);
    const int column = static_cast<int>(right * size.width);
    const int row = static_cast<int>(down * size.height);
    if (!std::isfinite(map(column, row))) continue;

    CoordinateSample& sample = samples.emplace_back();
    sample.pixel = Eigen::Vector2d(column, row);
    sample.coordinate = map(column, row);
    if (column + far >= size.width || row + far >= size.height) continue;

    const Eigen::Vector2d next(map(column + 1, row), map(column, row + 1));
    const Eigen::Vector2d away(map(column + far, row), map(column, row + far));
    if (!next.allFinite() || !away.allFinite()) continue;

    const Eigen::Vector2d change = next.array() - sample.coordinate;
    sample.change = {change, change};
  }

  if (is_of_whole_stripes(samples)) {
    for (CoordinateSample& sample : samples) sample.change.reset();
  }
  return samples;
}

}  // namespace

MapEvidence map_evidence(const Image<double>& coordinates) {
  MapEvidence evidence;
  evidence.samples = spread_samples(coordinates);
  const std::size_t valid = finite_values(coordinates).size();

  evidence.high = rising_end(coordinates, valid);

  // The low end is the high end of the negative.
  Image<double> negative = coordinates;
  for (double& coordinate : negative) coordinate = -coordinate;
  evidence.low = rising_end(negative, valid);
  if (evidence.low) evidence.low->coordinate *= -1;
  return evidence;
}

MapEvidence changed(MapEvidence evidence, double scale, double shift) {
  for (CoordinateSample& sample : evidence.samples) {
    sample.coordinate = scale * sample.coordinate + shift;
    if (!sample.change) continue;
    sample.change->coordinate *= scale;
    sample.change->phase *= scale;
  }

  for (std::optional<LightEnd>* const end : {&evidence.low, &evidence.high}) {
    if (!*end) continue;
    (*end)->coordinate = scale * (*end)->coordinate + shift;
    (*end)->step *= std::abs(scale);
  }

  if (scale < 0) std::swap(evidence.low, evidence.high);
  return evidence;
}

double MapFit::misfit() const {
  // Every term is 1 at its limit.
  return scan.misfit() + end_error / most_end_error + exceeding / most_exceeding;
}

MapFit fit_of(const MapEvidence& evidence, const Scanner& scanner, Axis axis,
              const PictureTurn& turn) {
  MapFit fit;

  // 1. Points, depths and slope.
  fit.scan.geometry = geometry_evidence(evidence.samples, {}, scanner, axis, turn);

  // 2. The ends of the light, which are half a pixel before the first and after the last one's
  // centre. The camera sees them no better than to two projector pixels.
  const double pixel = 1.0 / length_along(axis, scanner.projector.size);
  const auto compare = [&](const std::optional<LightEnd>& end, double expected, double outwards) {
    if (!end) return;
    const double error = (end->coordinate - expected) / std::max(end->step, 2 * pixel);
    if (std::abs(error) <= fit.end_error) return;
    fit.end_error = std::abs(error);
    fit.end_is_beyond = error * outwards > 0;
  };
  compare(evidence.low, -pixel / 2, -1);
  compare(evidence.high, 1 - pixel / 2, 1);

  // 3. Coordinates that no light has.
  constexpr double margin = 0.01;
  const auto exceeding = std::ranges::count_if(evidence.samples, [&](const CoordinateSample& s) {
    return !(s.coordinate >= -margin && s.coordinate <= 1 + margin);
  });
  if (!evidence.samples.empty()) {
    fit.exceeding = static_cast<double>(exceeding) / static_cast<double>(evidence.samples.size());
  }
  return fit;
}

}  // namespace slipstream
