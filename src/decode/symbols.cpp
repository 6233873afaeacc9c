#include "decode/symbols.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "base/moving_mean.h"
#include "decode/carrier.h"
#include "decode/located_pixels.h"

namespace slipstream {
namespace {

constexpr int none = -1, kinds = 3;

struct Vector {
  float x = 0, y = 0;

  friend Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y}; }
  friend Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y}; }
  friend Vector operator*(float s, Vector a) { return {s * a.x, s * a.y}; }
};
float cross(Vector a, Vector b) {
  return a.x * b.y - a.y * b.x;
}

struct Place {
  int column = none, row = none;

  friend bool operator==(const Place&, const Place&) = default;
};

struct Spot {
  Vector at{};
  int left = none, right = none, above = none, below = none;
  int symbol = none;
  float coordinate = 0, modulation = 0;
  std::vector<Place> votes{};
  Place place{};
};
using Spots = std::vector<Spot>;
using Link = int Spot::*;

/// Pixels from symbol to symbol along and across the axis, from the image's spectrum. It does not
/// give the grid's slant: with few symbols that is noise.
std::optional<Vector> pitch_of(const SymbolGrid& grid, const Image<float>& picture) {
  constexpr double least = 4, most = 200;  // pixels

  const double along = 1 / found_carriers(picture, {1.0 * grid.columns}, true).front().right,
               across = 1 / found_carriers(picture, {1.0 * grid.rows()}, false).front().down;
  if (!(along >= least && along <= most && across >= least && across <= most)) return std::nullopt;
  return Vector{static_cast<float>(along), static_cast<float>(across)};
}

/// Local maxima within a third of a symbol; `numbers` is set to the index of each.
Spots spots_of(Image<float> smooth, Vector pitch, Image<int>& numbers) {
  constexpr float least = 2;  // grey levels
  const auto [width, height] = smooth.size();

  const int reach_x = std::max(1, static_cast<int>(0.33F * pitch.x)),
            reach_y = std::max(1, static_cast<int>(0.33F * pitch.y));

  // The vertex of the parabola through three levels, pixels from the middle one.
  const auto vertex = [](float before, float here, float after) {
    const float curvature = before - 2 * here + after;
    return curvature < 0 ? (before - after) / (2 * curvature) : 0;
  };

  Spots spots;
  for (int row = reach_y; row < height - reach_y; ++row) {
    for (int column = reach_x; column < width - reach_x; ++column) {
      const float here = smooth(column, row);

      // The first of equal levels counts.
      bool highest = here > least;
      for (int y = row - reach_y; highest && y <= row + reach_y; ++y) {
        for (int x = column - reach_x; highest && x <= column + reach_x; ++x) {
          const bool earlier = y < row || (y == row && x < column);
          highest = earlier ? smooth(x, y) < here : smooth(x, y) <= here;
        }
      }
      if (!highest) continue;

      numbers(column, row) = static_cast<int>(spots.size());
      const float x = vertex(smooth(column - 1, row), here, smooth(column + 1, row)),
                  y = vertex(smooth(column, row - 1), here, smooth(column, row + 1));
      spots.push_back({.at = {static_cast<float>(column) + x, static_cast<float>(row) + y}});
    }
  }

  return spots;
}

/// The spot nearest to a position, within a fraction of a symbol.
int nearest(const Spots& spots, const Image<int>& numbers, Vector at, Vector pitch) {
  constexpr float share = 0.4F;
  const float reach_x = share * pitch.x, reach_y = share * pitch.y;
  const int last_x = std::min(static_cast<int>(at.x + reach_x), numbers.width() - 1),
            last_y = std::min(static_cast<int>(at.y + reach_y), numbers.height() - 1);

  int found = none;
  float least = 1;
  for (int y = std::max(static_cast<int>(at.y - reach_y), 0); y <= last_y; ++y) {
    for (int x = std::max(static_cast<int>(at.x - reach_x), 0); x <= last_x; ++x) {
      const int i = numbers(x, y);
      if (i == none) continue;

      const Vector off = spots[i].at - at;
      const float distance = std::hypot(off.x / reach_x, off.y / reach_y);
      if (distance < least) found = i;
      least = std::min(distance, least);
    }
  }

  return found;
}

/// Links spots that find each other: first at the image's pitch, then at their neighbours' spacing.
void link(Spots& spots, const Image<int>& numbers, Vector pitch) {
  // Links of one round give the next one better steps.
  constexpr int rounds = 4;

  const auto link_all = [&](Link next, Link previous, Link beside, Link other_side, Vector usual) {
    // The step that led here, or a neighbour's, or the usual one.
    const auto step_at = [&](const Spot& from) {
      if (from.*previous != none) return from.at - spots[from.*previous].at;
      for (const Link side : {beside, other_side}) {
        if (from.*side == none) continue;
        const Spot& neighbour = spots[from.*side];
        if (neighbour.*next != none) return spots[neighbour.*next].at - neighbour.at;
      }
      return usual;
    };

    for (int i = 0; i < std::ssize(spots); ++i) {
      Spot& here = spots[i];
      if (here.*next != none) continue;

      const Vector step = step_at(here);

      // Both must find each other.
      const int j = nearest(spots, numbers, here.at + step, pitch);
      if (j == none || spots[j].*previous != none) continue;
      if (nearest(spots, numbers, spots[j].at - step, pitch) != i) continue;

      here.*next = j;
      spots[j].*previous = i;
    }
  };

  for (int round = 0; round < rounds; ++round) {
    link_all(&Spot::right, &Spot::left, &Spot::above, &Spot::below, {pitch.x, 0});
    link_all(&Spot::below, &Spot::above, &Spot::left, &Spot::right, {0, pitch.y});
    link_all(&Spot::left, &Spot::right, &Spot::above, &Spot::below, {-pitch.x, 0});
    link_all(&Spot::above, &Spot::below, &Spot::left, &Spot::right, {0, -pitch.y});
  }
}

/// Classifies spots as symbols, from the extent of each in a cell spanned by its neighbours.
void classify(Spots& spots, const Image<float>& picture) {
  constexpr int side = 9;
  constexpr float cell = 0.9F, round = 0.25F, elongated = 0.4F;

  const auto offset = [](int i) { return cell * (static_cast<float>(i) / (side - 1) - 0.5F); };

  const auto pixel = [](float place, int count) {
    return static_cast<int>(std::lround(std::clamp(place, 0.0F, static_cast<float>(count - 1))));
  };
  // Mean step to the neighbours; the only one at an end.
  const auto step = [&](const Spot& from, int before, int after) {
    const Vector a = before == none ? from.at : spots[before].at,
                 b = after == none ? from.at : spots[after].at;
    return (before == none || after == none ? 1.0F : 0.5F) * (b - a);
  };

  for (Spot& here : spots) {
    const Vector along = step(here, here.left, here.right),
                 across = step(here, here.above, here.below);
    if (cross(along, across) <= 0) continue;

    // 1. Levels over the spot's cell, with the surface's slant.
    std::array<float, side * side> levels{};
    for (int i = 0; i < side * side; ++i) {
      const Vector at = here.at + offset(i % side) * along + offset(i / side) * across;
      levels[i] = picture(pixel(at.x, picture.width()), pixel(at.y, picture.height()));
    }

    // 2. Second moments of the light above a quarter of the range.
    const auto [darkest, brightest] = std::minmax_element(levels.begin(), levels.end());
    here.modulation = (*brightest - *darkest) / 2;
    const float floor = *darkest + here.modulation / 2;

    float more_along = 0, sum = 0;
    for (int i = 0; i < side * side; ++i) {
      const float light = std::max(levels[i] - floor, 0.0F);
      const float u = offset(i % side), v = offset(i / side);
      more_along += light * (u * u - v * v);
      sum += light * (u * u + v * v);
    }

    // 3. Round, or elongated along or across the axis; else unknown.
    if (!(sum > 0)) continue;
    const float share = more_along / sum;
    if (std::abs(share) < round) here.symbol = 0;
    if (std::abs(share) > elongated) here.symbol = share > 0 ? 1 : 2;
  }
}

/// The spots of a square around one, row by row; empty unless all exist and are classified.
std::vector<int> square_about(Spots& spots, int middle) {
  std::vector<int> square;
  for (const int row : {spots[middle].above, middle, spots[middle].below}) {
    if (row == none) return {};
    for (const int i : {spots[row].left, row, spots[row].right}) {
      if (i == none || spots[i].symbol == none) return {};
      square.push_back(i);
    }
  }

  return square;
}

/// Squares give their spots' positions; a spot requires two that agree and hardly any that differ.
void vote(Spots& spots, const SymbolGrid& grid) {
  static_assert(symbol_window == 3);

  // 1. The place of each square of nine symbols in the grid, by its symbols as a number.
  std::vector<Place> shown(19683);  // 3^9: the centres of all squares
  for (int row = 1; row + 1 < grid.rows(); ++row) {
    for (int column = 1; column + 1 < grid.columns; ++column) {
      std::size_t key = 0;
      for (int i = 0; i < 9; ++i) {
        const int at = (row - 1 + i / 3) * grid.columns + column - 1 + i % 3;
        key = kinds * key + grid.symbols[at];
      }
      shown[key] = {column, row};
    }
  }

  // 2. Each complete square votes for the places of its nine spots.
  for (int i = 0; i < static_cast<int>(spots.size()); ++i) {
    const std::vector<int> square = square_about(spots, i);
    if (square.empty()) continue;

    std::size_t key = 0;
    for (const int j : square) key = kinds * key + spots[j].symbol;
    const auto [column, row] = shown[key];
    if (column == none) continue;

    for (int k = 0; k < 9; ++k) {
      spots[square[k]].votes.push_back({column - 1 + k % 3, row - 1 + k / 3});
    }
  }

  // 3. A spot takes the place that over three quarters of its votes agree on.
  for (Spot& here : spots) {
    for (const Place& place : here.votes) {
      const auto count = std::count(here.votes.begin(), here.votes.end(), place);
      if (!(count >= 2 && 4 * count > 3 * std::ssize(here.votes))) continue;

      here.place = place;
      here.coordinate =
          (static_cast<float>(place.column) + 0.5F) / static_cast<float>(grid.columns);
    }
  }
}

/// Whether the step to the next spot is similar to an adjacent one: otherwise surfaces differ.
bool goes_on(const Spots& spots, const Spot& from, Link next, Link previous, Vector pitch) {
  constexpr float most = 0.15F;  // of a symbol
  const auto at = [&](int i) { return spots[i].at; };

  const Spot& to = spots[from.*next];
  const Vector step = to.at - from.at;

  const auto alike = [&](Vector other) {
    return std::hypot((other.x - step.x) / pitch.x, (other.y - step.y) / pitch.y) < most;
  };

  return (from.*previous != none && alike(from.at - at(from.*previous))) ||
         (to.*next != none && alike(at(to.*next) - to.at));
}

/// Interpolates the pixels of a triangle between its corners.
void fill(const Spot& a, const Spot& b, const Spot& c, LocatedPixels& to) {
  const float area = cross(b.at - a.at, c.at - a.at);
  if (!(area > 0)) return;

  // The triangle's bounding box.
  const auto [left, right] = std::minmax({a.at.x, b.at.x, c.at.x});
  const auto [top, bottom] = std::minmax({a.at.y, b.at.y, c.at.y});
  for (int y = static_cast<int>(std::ceil(top)); static_cast<float>(y) <= bottom; ++y) {
    for (int x = static_cast<int>(std::ceil(left)); static_cast<float>(x) <= right; ++x) {
      const Vector at = Vector{static_cast<float>(x), static_cast<float>(y)} - a.at;

      // Barycentric coordinates: the shares of the corners b and c.
      const float of_b = cross(at, c.at - a.at) / area, of_c = cross(b.at - a.at, at) / area;
      if (of_b < 0 || of_c < 0 || of_b + of_c > 1) continue;

      to.coordinate(x, y) = a.coordinate + of_b * (b.coordinate - a.coordinate) +
                            of_c * (c.coordinate - a.coordinate);
      to.modulation(x, y) = a.modulation;
    }
  }
}

}  // namespace

LocatedPixels located_by_symbols(const SymbolGrid& grid, const Image<float>& picture) {
  LocatedPixels located(picture.size());
  const std::optional<Vector> pitch = pitch_of(grid, picture);
  if (!pitch) return located;

  // 1. Spots: smooth over noise, and remove the mean over a symbol.
  Image<float> smooth = picture, mean = picture, scratch;
  const auto window = [&](float share) {
    return Size{odd_length(share * pitch->x), odd_length(share * pitch->y)};
  };

  take_moving_mean(mean, window(1), scratch);
  take_moving_mean(smooth, window(0.35F), scratch);
  std::transform(smooth.begin(), smooth.end(), mean.begin(), smooth.begin(), std::minus<>());

  Image<int> numbers(picture.size(), none);
  Spots spots = spots_of(std::move(smooth), *pitch, numbers);

  // 2. Their neighbours, symbols and places in the grid.
  link(spots, numbers, *pitch);
  classify(spots, picture);
  vote(spots, grid);

  // 3. Interpolate between four spots whose places are next to each other.
  for (const Spot& a : spots) {
    if (a.place.row == none || a.right == none || a.below == none) continue;

    const Spot &b = spots[a.right], &c = spots[a.below];
    if (b.below == none || b.below != c.right) continue;

    const Spot& d = spots[b.below];
    const auto [column, row] = a.place;
    const bool agree = b.place == Place{column + 1, row} && c.place == Place{column, row + 1} &&
                       d.place == Place{column + 1, row + 1};

    // Steps that change suddenly cross from one surface to another.
    const auto along = [&](const Spot& from) {
      return goes_on(spots, from, &Spot::right, &Spot::left, *pitch);
    };
    const auto across = [&](const Spot& from) {
      return goes_on(spots, from, &Spot::below, &Spot::above, *pitch);
    };

    if (!agree || !along(a) || !along(c) || !across(a) || !across(b)) continue;
    fill(a, b, c, located);
    fill(b, d, c, located);
  }

  return located;
}

}  // namespace slipstream
