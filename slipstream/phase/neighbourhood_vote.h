#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdlib>
#include <vector>

#include "slipstream/image/parallel_rows.h"

namespace slipstream {

/// Which neighbours are asked, and how much they count.
struct NeighbourhoodChoice {
  int radius = 2;              ///< of the square window around the pixel, 1 or 2
  double steepest = 0.25;      ///< periods per pixel; a step of the phase above it is an edge
  double roughest = 0.05;      ///< periods; what a step may differ from those before and after it
  double most_evidence = 4;    ///< a neighbour's evidence counts no more than this
  double disagreement = 0.25;  ///< cost of a neighbour that chose otherwise
  /// So many of the eight neighbours that hold in the end what the pixel said alone show an edge
  /// that the wrapped phase does not, one of whole periods: there the pixel's own choice stands.
  int hidden_edge = 1;
  int passes = 3;
};

struct PixelPlace {
  int row = 0, column = 0;
  auto operator<=>(const PixelPlace&) const = default;
};

/// A choice is told as a shift: the fringe order chosen less the one that the pixel said alone.
struct ShiftedPixel {
  PixelPlace place;
  int shift = 0;
};

/// What a vote keeps between its passes; kept from scan to scan it spares allocations.
struct NeighbourhoodVoteLists {
  std::vector<PixelPlace> open;        ///< pixels whose neighbours disagree with them
  std::vector<ShiftedPixel> choices;   ///< of those, in one pass
  std::vector<PixelPlace> moved;       ///< in one pass
  std::vector<PixelPlace> ever_moved;  ///< in any
};

/// Chooses fringe orders by the neighbourhood, see choose_with_neighbours, and looks at no pixel
/// but those in doubt and their neighbours. `Field` says, for any pixel and a few places past the
/// ends of the picture:
///   double periods(int column, int row)  the phase unwrapped by the pixel's own order, in periods;
///                                        NaN where it means nothing and outside the picture
///   double cost(int column, int row, int shift)  FringeOrderCost of a shifted order
///   int shift(int column, int row), void set_shift(int column, int row, int shift)
template <class Field>
class NeighbourhoodVote {
 public:
  NeighbourhoodVote(Field& field, const NeighbourhoodChoice& settings)
      : field_(field), settings_(settings) {}

  /// Whether a neighbour on the same surface implies another order.
  [[nodiscard]] bool disagrees(int column, int row) const {
    return std::any_of(directions.begin(), directions.end(), [&](const auto& direction) {
      const auto [dx, dy] = direction;
      return linked(column, row, dx, dy) &&
             field_.shift(column + dx, row + dy) !=
                 field_.shift(column, row) + shift_step(column, row, dx, dy);
    });
  }

  /// `lists.open` holds, in any order, at least the pixels that disagree; the field's shifts are 0
  /// and are then those chosen. `lists.ever_moved` holds all pixels that have one.
  void operator()(NeighbourhoodVoteLists& lists) {
    lists.ever_moved.clear();
    for (int pass = 0; pass < settings_.passes && !lists.open.empty(); ++pass) {
      keep_those_that_disagree(lists.open);
      choose(lists);
      open_around_the_moved(lists);
    }
    sort_once(lists.ever_moved);
    for (int pass = 0; pass < settings_.passes; ++pass) restore_at_hidden_edges(lists);
    std::erase_if(lists.ever_moved,
                  [&](PixelPlace at) { return field_.shift(at.column, at.row) == 0; });
  }

 private:
  static constexpr std::array<std::array<int, 2>, 4> directions{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

  /// A pixel on the same surface, and its shift less that of the middle where both agree.
  struct Neighbour {
    int column, row, shift_step;
  };

  /// The middle comes first.
  struct Surface {
    std::array<Neighbour, 25> pixels;
    std::size_t count = 0;

    [[nodiscard]] const Neighbour* begin() const { return pixels.data(); }
    [[nodiscard]] const Neighbour* end() const { return pixels.data() + count; }
  };

  static double nearest_whole(double periods) {
    constexpr double rounding = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds
    return (periods + rounding) - rounding;
  }
  static double part(double periods) { return periods - nearest_whole(periods); }

  [[nodiscard]] int shift_step(int column, int row, int dx, int dy) const {
    return static_cast<int>(
        nearest_whole(field_.periods(column, row) - field_.periods(column + dx, row + dy)));
  }

  /// Whether the surface goes on from a pixel to the next along (dx, dy), dx + dy = +-1: an edge
  /// differs from the steps on either side of it.
  [[nodiscard]] bool linked(int column, int row, int dx, int dy) const {
    const double at = field_.periods(column, row);
    const double next = field_.periods(column + dx, row + dy);
    const double step = part(next - at);
    if (!(std::abs(step) <= settings_.steepest)) return false;
    const double before = part(at - field_.periods(column - dx, row - dy));
    const double after = part(field_.periods(column + 2 * dx, row + 2 * dy) - next);
    if (std::isnan(before) && std::isnan(after)) return true;
    return std::abs(step - before) <= settings_.roughest ||
           std::abs(step - after) <= settings_.roughest;
  }

  /// All that are reached from the middle within the window.
  [[nodiscard]] Surface same_surface(PixelPlace middle, int radius) const {
    Surface found;
    std::array<bool, 25> reached{};
    const auto reach = [&](int column, int row, int shift_step) {
      const int index = (row - middle.row + 2) * 5 + column - middle.column + 2;
      reached[static_cast<std::size_t>(index)] = true;
      found.pixels[found.count++] = {column, row, shift_step};
    };
    const auto is_open = [&](int column, int row) {
      const int dx = column - middle.column, dy = row - middle.row;
      return std::abs(dx) <= radius && std::abs(dy) <= radius &&
             !reached[static_cast<std::size_t>((dy + 2) * 5 + dx + 2)];
    };
    reach(middle.column, middle.row, 0);
    for (std::size_t next = 0; next < found.count; ++next) {
      const auto [column, row, step] = found.pixels[next];
      for (const auto& [dx, dy] : directions) {
        if (!is_open(column + dx, row + dy) || !linked(column, row, dx, dy)) continue;
        reach(column + dx, row + dy, step + shift_step(column, row, dx, dy));
      }
    }
    return found;
  }

  /// The cost of a shift of the middle to the whole surface.
  [[nodiscard]] double total(const Surface& surface, int shift) const {
    const Neighbour& middle = *surface.begin();
    double sum = field_.cost(middle.column, middle.row, shift);
    for (const Neighbour* n = surface.begin() + 1; n != surface.end(); ++n) {
      const int implied = shift + n->shift_step;
      if (implied != 0) {
        const double against =
            field_.cost(n->column, n->row, implied) - field_.cost(n->column, n->row, 0);
        sum += std::min(against, settings_.most_evidence);
      }
      if (field_.shift(n->column, n->row) != implied) sum += settings_.disagreement;
    }
    return sum;
  }

  /// The shift of the middle that costs least, among its own and those that neighbours imply.
  [[nodiscard]] int least_cost_shift(PixelPlace middle) const {
    const Surface surface = same_surface(middle, settings_.radius);
    std::array<int, 25> candidates{};
    std::size_t count = 0;
    int best = 0;
    double least = 0;
    for (const auto& [column, row, shift_step] : surface) {
      const int implied = field_.shift(column, row) - shift_step;
      const auto known_end = candidates.begin() + static_cast<std::ptrdiff_t>(count);
      if (std::find(candidates.begin(), known_end, implied) != known_end) continue;
      candidates[count++] = implied;
      const double here = total(surface, implied);
      if (count > 1 && !(here < least)) continue;
      best = implied;
      least = here;
    }
    return best;
  }

  void keep_those_that_disagree(std::vector<PixelPlace>& open) const {
    std::erase_if(open, [&](PixelPlace at) { return !disagrees(at.column, at.row); });
  }

  /// One pass: all choose by what stood before it.
  void choose(NeighbourhoodVoteLists& lists) {
    constexpr int share = 64;
    lists.choices.resize(lists.open.size());
    struct Work {
      const NeighbourhoodVote& vote;
      NeighbourhoodVoteLists& lists;
      void operator()(int part) const {
        const std::size_t first = static_cast<std::size_t>(part) * share;
        const std::size_t last = std::min(first + share, lists.open.size());
        for (std::size_t i = first; i < last; ++i) {
          lists.choices[i] = {lists.open[i], vote.least_cost_shift(lists.open[i])};
        }
      }
    };
    const Work work{*this, lists};
    const int parts = static_cast<int>((lists.open.size() + share - 1) / share);
    if (parallel_threads() == 1) {
      for (int part = 0; part < parts; ++part) work(part);
    } else {
      // One captured reference: std::function then allocates nothing.
      for_each_row(parts, [&work](int part) { work(part); });
    }
    apply(lists);
  }

  void apply(NeighbourhoodVoteLists& lists) {
    lists.moved.clear();
    for (const auto& [at, shift] : lists.choices) {
      if (field_.shift(at.column, at.row) == shift) continue;
      field_.set_shift(at.column, at.row, shift);
      lists.moved.push_back(at);
    }
    lists.ever_moved.insert(lists.ever_moved.end(), lists.moved.begin(), lists.moved.end());
  }

  /// Only a pixel that sees one that moved can choose otherwise in the next pass.
  void open_around_the_moved(NeighbourhoodVoteLists& lists) const {
    lists.open.clear();
    for (const auto& [row, column] : lists.moved) {
      for (int dy = -settings_.radius; dy <= settings_.radius; ++dy) {
        for (int dx = -settings_.radius; dx <= settings_.radius; ++dx) {
          if (std::isnan(field_.periods(column + dx, row + dy))) continue;
          lists.open.push_back({row + dy, column + dx});
        }
      }
    }
    sort_once(lists.open);
  }

  static void sort_once(std::vector<PixelPlace>& places) {
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
  }

  /// One pass over the moved pixels: back to what the pixel said alone where enough of its eight
  /// neighbours, those on the same surface, agree with that.
  void restore_at_hidden_edges(NeighbourhoodVoteLists& lists) {
    lists.choices.clear();
    for (const PixelPlace at : lists.ever_moved) {
      if (field_.shift(at.column, at.row) == 0) continue;
      const Surface surface = same_surface(at, 1);
      const auto supporters =
          std::count_if(surface.begin() + 1, surface.end(), [&](const Neighbour& neighbour) {
            return field_.shift(neighbour.column, neighbour.row) == neighbour.shift_step;
          });
      if (supporters >= settings_.hidden_edge) lists.choices.push_back({at, 0});
    }
    for (const auto& [at, shift] : lists.choices) field_.set_shift(at.column, at.row, shift);
  }

  Field& field_;
  NeighbourhoodChoice settings_;
};

}  // namespace slipstream
