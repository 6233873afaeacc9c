#include "decode/neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "base/parallel_rows.h"
#include "decode/located_pixels.h"
#include "decode/symbols.h"

namespace slipstream {
namespace {

using Rise = std::array<float, 3>;  // per channel, -1 to 1

struct Edge {
  float x = 0;
  Rise rise{};
  int transition = -1;  ///< from that stripe to the next; -1: unknown
};
using Edges = std::vector<Edge>;

/// Finds where the channels' ratios to the strongest change most: paint changes all equally, and
/// one is lit on both sides of each transition. `stripe`: approximate width of a stripe, pixels.
Edges edges_of(const std::vector<Image<float>>& channels, int row, float stripe) {
  constexpr float dimmest = 6, least = 0.35F;  // grey levels; share of full light, over a stripe
  const auto count = static_cast<std::size_t>(channels.front().width());
  const auto reach = static_cast<std::size_t>(std::max(stripe / 5, 1.0F));

  // 1. Each channel's share of the strongest, 0 in the dark.
  std::vector<Rise> share(count), slope(count);
  std::vector<float> squares(count);
  for (std::size_t x = 0; x < count; ++x) {
    for (std::size_t c = 0; c < 3; ++c) share[x][c] = channels[c].row(row)[x];
    const float brightest = std::max({share[x][0], share[x][1], share[x][2]});
    for (float& level : share[x]) level = brightest < dimmest ? 0 : level / brightest;
  }

  // 2. Slopes over a fifth of a stripe either way, per stripe.
  for (std::size_t x = reach; x + reach < count; ++x) {
    for (std::size_t c = 0; c < 3; ++c) {
      slope[x][c] =
          stripe * (share[x + reach][c] - share[x - reach][c]) / static_cast<float>(2 * reach);
      squares[x] += slope[x][c] * slope[x][c];
    }
  }

  // 3. Edges are the steepest places.
  Edges edges;
  for (std::size_t x = 2 * reach; x + 2 * reach < count; ++x) {
    Rise rise = slope[x];
    const float steepest = std::max({std::abs(rise[0]), std::abs(rise[1]), std::abs(rise[2])});

    bool highest = steepest >= least;
    for (std::size_t k = 1; highest && k <= reach; ++k) {
      highest = squares[x] > squares[x - k] && squares[x] >= squares[x + k];
    }
    if (!highest) continue;

    for (float& value : rise) value /= steepest;
    const auto along = [&](std::size_t at) {
      return rise[0] * slope[at][0] + rise[1] * slope[at][1] + rise[2] * slope[at][2];
    };

    // Centroid over the whole edge: a quarter of the noise of its steepest point.
    constexpr float part = 0.1F;

    float sum = along(x), moment = 0;
    const float end = part * sum;

    for (std::size_t k = 1; k <= x && along(x - k) > end; ++k) {
      sum += along(x - k);
      moment -= static_cast<float>(k) * along(x - k);
    }
    for (std::size_t k = 1; x + k < count && along(x + k) > end; ++k) {
      sum += along(x + k);
      moment += static_cast<float>(k) * along(x + k);
    }

    edges.push_back({.x = static_cast<float>(x) + moment / sum, .rise = rise});
  }

  return edges;
}

/// How well an edge fits a transition: -1 to 1.
float fit(const Rise& seen, const Rise& shown) {
  float worst = 1;
  for (std::size_t c = 0; c < 3; ++c) {
    // A channel that must not change, or one that must change by a full step.
    const float score =
        shown[c] == 0 ? 1 - 2 * std::abs(seen[c]) : std::max(2 * seen[c] * shown[c] - 1, -1.0F);
    worst = std::min(worst, score);
  }

  return worst;
}

/// Matches edges to transitions. A path scores the sum of the fits minus the cost of gaps (an extra
/// edge or a missing transition) and breaks (continuing at any other transition).
void match(Edges& edges, const std::vector<Rise>& transitions) {
  constexpr float gap = 0.6F, break_cost = 3, margin = 1, rounding = 1e-3F;
  constexpr float never = -std::numeric_limits<float>::infinity();
  const std::size_t count = edges.size(), shown = transitions.size();

  // 1. Forwards: the best path that ends at each pair of edge and transition. It starts or breaks
  // there, goes on from the transition before, or skips one. Edges may be skipped, too.
  std::vector<float> fits(count * shown), matched(count * shown);
  std::vector<float> last(shown + 2, never), next(shown + 2, never);  // two more before the first

  float best = 0;  // of all paths that end here or before
  for (std::size_t i = 0; i < count; ++i) {
    float ended = best;
    for (std::size_t j = 0; j < shown; ++j) {
      const std::size_t at = i * shown + j;
      fits[at] = fit(edges[i].rise, transitions[j]);
      matched[at] = fits[at] + std::max({best - break_cost, last[j + 1], last[j] - gap});
      next[j + 2] = std::max(matched[at], last[j + 2] - gap);
      ended = std::max(ended, next[j + 2]);
    }

    best = ended;
    std::swap(last, next);
  }

  // 2. Backwards: the best continuation after each transition, so that every pair has the score of
  // the best whole path through it.
  std::vector<float> after(shown + 2, 0), before(shown + 2, never);  // two more past the last
  after[shown] = after[shown + 1] = never;

  float rest = 0;  // of the best path that starts later
  for (std::size_t i = count; i-- > 0;) {
    const float* const of_edge = fits.data() + i * shown;
    float highest = never, second = never, started = rest;

    for (std::size_t j = 0; j < shown; ++j) {
      const float whole = matched[i * shown + j] + after[j];
      if (whole > highest) edges[i].transition = static_cast<int>(j);

      second = std::max(second, std::min(whole, highest));
      highest = std::max(highest, whole);
      started = std::max(started, of_edge[j] - break_cost + after[j]);
    }

    // The transition of the best path, if no other comes near.
    if (highest < best - rounding || second > best - margin) edges[i].transition = -1;
    rest = started;

    // The same for the edge before: a new start, this edge skipped, the next transition, or the one
    // after it.
    for (std::size_t j = 0; j < shown; ++j) {
      const float one = j + 1 < shown ? of_edge[j + 1] + after[j + 1] : never;
      const float two = j + 2 < shown ? of_edge[j + 2] + after[j + 2] - gap : never;
      before[j] = std::max({rest, after[j] - gap, one, two});
    }

    std::swap(after, before);
  }
}

/// The same transition `off` rows away, near the edge; null if there is none.
const Edge* same(const std::vector<Edges>& rows, std::ptrdiff_t row, std::ptrdiff_t off,
                 const Edge& edge) {
  if (row + off < 0 || row + off >= std::ssize(rows)) return nullptr;

  const float near = 3 * static_cast<float>(std::abs(off));  // pixels
  for (const Edge& other : rows[row + off]) {
    if (other.transition == edge.transition && std::abs(other.x - edge.x) <= near) return &other;
  }

  return nullptr;
}

/// Edges that an adjacent row confirms, at the mean over some rows on both sides.
Edges confirmed(const std::vector<Edges>& rows, std::ptrdiff_t row) {
  constexpr std::ptrdiff_t most = 3;
  Edges edges;
  for (Edge edge : rows[row]) {
    if (edge.transition < 0 || !(same(rows, row, 1, edge) || same(rows, row, -1, edge))) continue;

    float sum = edge.x, count = 1;
    for (std::ptrdiff_t off = 1; off <= most; ++off) {
      const Edge *const above = same(rows, row, -off, edge), *const below =
                                                                 same(rows, row, off, edge);
      if (above == nullptr || below == nullptr) break;
      sum += above->x + below->x;
      count += 2;
    }

    edge.x = sum / count;
    edges.push_back(edge);
  }

  return edges;
}

/// Interpolates between neighbouring transitions unless their spacing shows two surfaces.
void fill(const Edges& edges, const std::vector<Image<float>>& channels, int row, int stripes,
          LocatedPixels& to) {
  constexpr float most = 1.25F;  // times the adjacent spacing

  const auto distance = [&](std::size_t i) {  // to the next edge, if that is the next transition
    const bool follows = i + 1 < edges.size() && edges[i + 1].transition == edges[i].transition + 1;
    return follows ? edges[i + 1].x - edges[i].x : 0;
  };

  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const float here = distance(i), before = i > 0 ? distance(i - 1) : 0, after = distance(i + 1);

    const auto alike = [&](float other) {
      return other > 0 && here <= most * other && other <= most * here;
    };
    if (here <= 0 || !(alike(before) || alike(after))) continue;

    // The modulation of the brightest pixel serves for all between the two edges.
    const int first = static_cast<int>(std::ceil(edges[i].x)),
              last = static_cast<int>(std::floor(edges[i + 1].x));
    float strongest = 0;

    // Stripes are counted from the field's edge; transition j lies before stripe j + 1.
    for (int x = first; x <= last; ++x) {
      const auto [dark, lit] =
          std::minmax({channels[0](x, row), channels[1](x, row), channels[2](x, row)});
      strongest = std::max(strongest, (lit - dark) / 2);
    }
    for (int x = first; x <= last; ++x) {
      const float stripe =
          static_cast<float>(edges[i].transition + 1) + (static_cast<float>(x) - edges[i].x) / here;

      to.coordinate(x, row) = stripe / static_cast<float>(stripes);
      to.modulation(x, row) = strongest;
    }
  }
}

Image<float> transposed(const Image<float>& image) {
  Image<float> turned({image.height(), image.width()});
  for_each_pixel_in_order(image.size(), [&](int x, int y) { turned(y, x) = image(x, y); });
  return turned;
}

/// Locates pixels from vertical stripes in three channels. A transition is where a channel rises or
/// falls relative to the strongest along a row; dynamic programming matches each row's transitions
/// to the displayed ones (after Zhang, Curless and Seitz 2002), where a break in the order has a
/// cost. Drops transitions that are ambiguous or absent from the adjacent rows, and interpolates
/// pixels between neighbouring ones.
LocatedPixels located_by_stripes(const SymbolGrid& grid,
                                 const std::vector<Image<float>>& channels) {
  // Rise of each channel from stripe to stripe: -1, 0 or 1.
  std::vector<Rise> transitions(grid.symbols.size() - 1);
  for (std::size_t j = 0; j < transitions.size(); ++j) {
    for (unsigned c = 0; c < 3; ++c) {
      transitions[j][c] =
          static_cast<float>(((grid.symbols[j + 1] >> c) & 1) - ((grid.symbols[j] >> c) & 1));
    }
  }

  // Rows by themselves, then with the rows next to them.
  LocatedPixels located(channels.front().size());
  const auto [width, height] = located.coordinate.size();
  const float stripe = static_cast<float>(width) / static_cast<float>(grid.columns);

  std::vector<Edges> rows(static_cast<std::size_t>(height));

  for_each_row(height, [&](int row) {
    Edges& edges = rows[row];
    edges = edges_of(channels, row, stripe);
    match(edges, transitions);
  });
  for_each_row(height,
               [&](int row) { fill(confirmed(rows, row), channels, row, grid.columns, located); });

  return located;
}

}  // namespace

LocatedPixels located_by_neighbours(const SymbolGrid& grid, Axis axis,
                                    std::vector<Image<float>> frames) {
  if (axis == Axis::y) {
    for (Image<float>& frame : frames) frame = transposed(frame);
  }

  LocatedPixels located =
      grid.rows() > 1 ? located_by_symbols(grid, frames.front()) : located_by_stripes(grid, frames);

  if (axis == Axis::y) {
    located.coordinate = transposed(located.coordinate);
    located.modulation = transposed(located.modulation);
  }

  return located;
}

}  // namespace slipstream
