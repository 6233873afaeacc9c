#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "base/parallel_rows.h"
#include "decode/surface_window.h"
#include "slipstream/image.h"

namespace slipstream {

struct PixelPlace {
  int row = 0, column = 0;
  auto operator<=>(const PixelPlace&) const = default;
};

/// A choice is stored as a shift: the chosen fringe order minus the pixel's own.
struct ShiftedPixel {
  PixelPlace place;
  int shift = 0;
};

/// Stored in place of a shift: to be decided by the exact rules.
inline constexpr int undecided = std::numeric_limits<int>::max();

struct VoteLimits {
  static constexpr double most_evidence = 4;    ///< upper limit for a neighbour's evidence
  static constexpr double disagreement = 0.25;  ///< cost of a neighbour with another choice
  /// Five standard deviations: a choice that costs the pixel more is excluded.
  static constexpr double sure = 25;
  /// Four standard deviations: a choice must be cheaper by this along a line of five pixels to
  /// override the rest of the window, as a wire is a line and noise is not.
  static constexpr double enough_along_a_line = 16;
};

/// State of a vote between passes; reuse it from scan to scan to avoid allocations.
struct NeighbourhoodVoteLists {
  std::vector<PixelPlace> open;        ///< pixels whose neighbours disagree with them
  std::vector<ShiftedPixel> choices;   ///< of the open pixels, in one pass
  std::vector<PixelPlace> moved;       ///< in one pass
  std::vector<PixelPlace> ever_moved;  ///< in any
};

/// Chooses fringe orders by the neighbourhood, see choose_with_neighbours, and reads only the
/// pixels in dispute and their neighbours. `Field` provides, for any pixel and up to four pixels
/// beyond the image:
///   double periods(int column, int row)  the phase unwrapped by the pixel's own order, in periods;
///                                        NaN where invalid and outside the image
///   void periods_around(int column, int row, PhaseWindow& window)  the same around a pixel, minus
///                                        the pixel's own
///   void foresee(const std::vector<PixelPlace>& open)  announces windows around those pixels
///   double against(PixelPlace at, int shift)  FringeOrderCost of a shifted order minus that of the
///                                             pixel's own
///   bool own_order_costs_least()  whether no shift costs a pixel less than its own order
///   int shift(PixelPlace at), void set_shift(PixelPlace at, int shift)  0 outside the image
/// and optionally, as a faster path for most pixels,
///   void hold_ballots(std::span<ShiftedPixel>, bool restores)
template <class Field>
class NeighbourhoodVote : private SurfaceWindow, private VoteLimits {
 public:
  explicit NeighbourhoodVote(Field& field) : field_(field) {}

  /// Whether a neighbour on the same surface implies another order.
  [[nodiscard]] bool disagrees(PixelPlace at) const {
    return may_disagree(at) && disagrees(at, links_around(at));
  }

  /// Requires in `lists.open`, in any order but once, at least the pixels that disagree, and all
  /// shifts 0. Sets the field's shifts; `lists.ever_moved` then lists all pixels with one.
  void operator()(NeighbourhoodVoteLists& lists) {
    // 1. Revise open pixels until they agree with their neighbours.
    lists.ever_moved.clear();
    for (int pass = 0; pass < passes && !lists.open.empty(); ++pass) {
      choose(lists);
      open_what_disagrees(lists);
    }

    // 2. Undo moves across edges that the wrapped phase does not show.
    sort_once(lists.ever_moved);
    lists.moved = lists.ever_moved;
    for (int pass = 0; pass < passes && !lists.moved.empty(); ++pass) {
      restore_at_hidden_edges(lists);
    }

    std::erase_if(lists.ever_moved, [&](PixelPlace at) { return field_.shift(at) == 0; });
  }

 private:
  static constexpr int passes = 3;

  static constexpr std::array<std::array<int, 2>, 4> directions{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

  [[nodiscard]] Links links_around(PixelPlace at) const {
    PhaseWindow window;
    field_.periods_around(at.column, at.row, window);
    return links_in(window);
  }

  static PixelPlace place(PixelPlace at, int cell) {
    return {at.row + cell / side - 2, at.column + cell % side - 2};
  }

  /// A pixel and all pixels that vote on its choice.
  class Ballot {
   public:
    Ballot(const NeighbourhoodVote& vote, PixelPlace at, const Surface& surface)
        : surface_(surface),
          field_(vote.field_),
          at_(at),
          costs_least_(vote.field_.own_order_costs_least()) {
      for (int cell = 0; cell < cells; ++cell) {
        shift_[index(cell)] = field_.shift(place(at, cell));
        moved_ |= Cells{shift_[index(cell)] != 0} << cell;
      }
    }

    /// The cheapest shift of the middle among its own and those that neighbours imply; candidates
    /// with the most votes come first.
    [[nodiscard]] int least_cost_shift() {
      const auto end = name_candidates();

      int best = 0;
      double least = std::numeric_limits<double>::infinity();
      for (auto candidate = candidates_.begin(); candidate != end; ++candidate) {
        const double here = total(*candidate, least);
        if (!(here < least)) continue;

        best = candidate->shift;
        least = here;
      }

      return shift_of_a_line(best, end);
    }

   private:
    struct Candidate {
      int shift;
      Cells voters;
    };

    [[nodiscard]] double against(int cell, int shift) const {
      return field_.against(place(at_, cell), shift);
    }

    using Candidates = std::array<Candidate, cells>;

    /// Fills `candidates_`, without those the pixel itself excludes; returns their end.
    typename Candidates::iterator name_candidates() {
      // The shift of the middle that each pixel of the surface implies.
      std::array<int, cells> implied;
      for (std::size_t i = 0; i < cells; ++i) implied[i] = shift_[i] - surface_.shift_step[i];

      // One candidate per different shift, with the pixels that imply it.
      auto end = candidates_.begin();
      for (Cells rest = surface_.pixels; rest != 0; ++end) {
        const int shift = implied[index(std::countr_zero(rest))];
        Cells voters = 0;
        for (int i = cells - 1; i >= 0; --i)
          voters = 2 * voters + Cells{implied[index(i)] == shift};

        *end = {shift, voters & rest};
        rest &= ~voters;
      }

      // Exclude shifts that the pixel's own evidence rules out; most votes first.
      end = std::remove_if(candidates_.begin(), end, [&](const Candidate& candidate) {
        return against(middle, candidate.shift) > sure;
      });

      std::sort(candidates_.begin(), end, [](const auto& a, const auto& b) {
        const int votes = std::popcount(a.voters), of_b = std::popcount(b.voters);
        return votes != of_b ? votes > of_b : a.shift < b.shift;
      });

      return end;
    }

    /// A wire one pixel wide is outvoted in every window, but not along its own line. Where a line
    /// of the wire and one of the surface behind it cross, the pixel itself decides.
    [[nodiscard]] int shift_of_a_line(int best, typename Candidates::iterator end) {
      int chosen = best;
      double most = enough_along_a_line;

      for (auto candidate = candidates_.begin(); candidate != end; ++candidate) {
        if (candidate->shift == best) continue;

        const LineEvidence evidence = line_evidence(best, *candidate);
        if (!(evidence.for_candidate > most)) continue;

        const bool crossing = evidence.for_best > enough_along_a_line;
        if (crossing && !(against(middle, candidate->shift) < against(middle, best))) continue;

        chosen = candidate->shift;
        most = evidence.for_candidate;
      }

      return chosen;
    }

    /// By how much each of two choices is cheaper, along the line that favours it most.
    struct LineEvidence {
      double for_best = 0, for_candidate = 0;
    };

    /// Zero if no line has three pixels, including the middle, that agree with the candidate.
    [[nodiscard]] LineEvidence line_evidence(int best, const Candidate& candidate) {
      LineEvidence found;

      // Most candidates have no line of three pixels: skip the sums for them.
      const Cells others = candidate.voters & ~bit(middle);
      if (std::none_of(line_cells.begin(), line_cells.end(), [others](Cells line) {
            const Cells suited = line & others;
            return (suited & (suited - 1)) != 0;  // two or more
          })) {
        return found;
      }

      // Cost that the candidate saves at each pixel of the surface.
      std::array<double, cells> saved{};
      for_each_cell(surface_.pixels, [&](int cell) {
        const int step = surface_.shift_step[index(cell)];
        saved[index(cell)] = against(cell, best + step) - against(cell, candidate.shift + step);
      });

      for (const Line& line : lines) {
        double sum = 0;
        for (const int cell : line) sum += saved[index(cell)];
        found.for_best = std::max(found.for_best, -sum);
        found.for_candidate = std::max(found.for_candidate, sum);
      }

      return found;
    }

    /// The cost of a shift of the middle to the whole surface; or, if no term can be negative, a
    /// partial sum of at least `enough`.
    [[nodiscard]] double total(const Candidate& candidate, double enough) const {
      if (!costs_least_) enough = std::numeric_limits<double>::infinity();

      const Cells others = surface_.pixels & ~bit(middle);

      // The middle's own cost, and a fixed one for each neighbour that implies another shift.
      double sum = against(middle, candidate.shift) +
                   disagreement * std::popcount(others & ~candidate.voters);

      // Neighbours would have to follow; content ones keep their own order at no cost.
      const Cells content = candidate.voters & ~moved_;
      for (Cells rest = others & ~content; rest != 0 && sum < enough; rest &= rest - 1) {
        const int cell = std::countr_zero(rest);
        const int implied = candidate.shift + surface_.shift_step[index(cell)];
        if (implied != 0) sum += std::min(against(cell, implied), most_evidence);
      }

      return sum;
    }

    const Surface& surface_;
    const Field& field_;
    PixelPlace at_;
    bool costs_least_;
    Cells moved_ = 0;
    std::array<int, cells> shift_;
    Candidates candidates_;
  };

  /// Whether one of the four neighbours implies another order.
  [[nodiscard]] bool disagrees(PixelPlace at, const Links& links) const {
    const int own = field_.shift(at);

    const auto implies_another = [&](int dx, int dy, const auto& linked, const auto& steps,
                                     int link, int sign) {
      return (linked & bit(link)) != 0 &&
             field_.shift({at.row + dy, at.column + dx}) != own + sign * steps[index(link)];
    };

    return implies_another(1, 0, links.right, links.right_step, middle, 1) ||
           implies_another(-1, 0, links.right, links.right_step, middle - 1, -1) ||
           implies_another(0, 1, links.down, links.down_step, middle, 1) ||
           implies_another(0, -1, links.down, links.down_step, middle - side, -1);
  }

  /// False only if no neighbour can disagree, wherever edges are.
  [[nodiscard]] bool may_disagree(PixelPlace at) const {
    const double own = field_.periods(at.column, at.row);
    if (std::isnan(own)) return false;  // outside the image there are no shifts

    const int shift = field_.shift(at);
    return std::any_of(directions.begin(), directions.end(), [&](const auto& direction) {
      const int column = at.column + direction[0], row = at.row + direction[1];
      const double step = field_.periods(column, row) - own;
      const double nearest = nearest_whole(step);
      return std::abs(step - nearest) <= steepest &&
             field_.shift({row, column}) != shift - static_cast<int>(nearest);
    });
  }

  [[nodiscard]] int chosen_shift(PixelPlace at) const {
    const Links links = links_around(at);
    if (!disagrees(at, links)) return field_.shift(at);

    const Surface surface = same_surface(links, whole_window);
    return Ballot(*this, at, surface).least_cost_shift();
  }

  /// One pass: all choose from the state before it.
  void choose(NeighbourhoodVoteLists& lists) {
    constexpr int share = 64;

    field_.foresee(lists.open);
    lists.choices.resize(lists.open.size());

    // A share of the open pixels: all by the quick path, the undecided ones by the exact rules.
    const auto work = [&](int part) {
      const std::size_t first = static_cast<std::size_t>(part) * share;
      const std::size_t last = std::min(first + share, lists.open.size());
      for (std::size_t i = first; i < last; ++i) lists.choices[i] = {lists.open[i], undecided};

      const auto choices = std::span(lists.choices).subspan(first, last - first);
      if constexpr (is_quick) field_.hold_ballots(choices, false);
      for (auto& [at, shift] : choices) {
        if (shift == undecided) shift = chosen_shift(at);
      }
    };

    // All choose before any shift is set.
    const int parts = static_cast<int>((lists.open.size() + share - 1) / share);
    if (parallel_threads() == 1) {
      for (int part = 0; part < parts; ++part) work(part);
    } else {
      // With one captured reference std::function does not allocate.
      for_each_row(parts, [&work](int part) { work(part); });
    }

    lists.moved.clear();
    for (const auto& [at, shift] : lists.choices) {
      if (field_.shift(at) == shift) continue;
      field_.set_shift(at, shift);
      lists.moved.push_back(at);
    }

    lists.ever_moved.insert(lists.ever_moved.end(), lists.moved.begin(), lists.moved.end());
  }

  /// For the next pass: pixels that were open and still disagree, and those that disagree because
  /// they or their neighbours moved.
  void open_what_disagrees(NeighbourhoodVoteLists& lists) const {
    if (lists.moved.empty()) return lists.open.clear();

    for (const auto& [row, column] : lists.moved) {
      for (const auto& [dx, dy] : directions) lists.open.push_back({row + dy, column + dx});
    }

    std::erase_if(lists.open, [&](PixelPlace at) { return !may_disagree(at); });
    sort_once(lists.open);
  }

  static void sort_once(std::vector<PixelPlace>& places) {
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
  }

  /// Whether one of its eight neighbours on the same surface agrees with the pixel's own order.
  [[nodiscard]] bool has_support(PixelPlace at) const {
    const Surface surface = same_surface(links_around(at), inner_window);

    bool supported = false;
    for_each_cell(surface.pixels & ~bit(middle), [&](int cell) {
      supported |= field_.shift(place(at, cell)) == surface.shift_step[index(cell)];
    });

    return supported;
  }

  /// One pass over `lists.moved`: restores the pixel's own order if one of its eight neighbours on
  /// the same surface agrees with it: that indicates an edge of whole periods, which the wrapped
  /// phase does not show. Leaves in `lists.moved` the pixels that the next pass may restore.
  void restore_at_hidden_edges(NeighbourhoodVoteLists& lists) {
    lists.choices.clear();
    for (const PixelPlace at : lists.moved) {
      if (field_.shift(at) != 0) lists.choices.push_back({at, undecided});
    }

    // Keep those to restore.
    if constexpr (is_quick) field_.hold_ballots(lists.choices, true);
    std::erase_if(lists.choices, [&](const ShiftedPixel& pixel) {
      return pixel.shift == undecided ? !has_support(pixel.place) : pixel.shift != 0;
    });

    // Their neighbours may now be restored, too.
    lists.moved.clear();
    for (const auto& [at, shift] : lists.choices) {
      field_.set_shift(at, 0);
      for_each_cell(inner_window, [&](int cell) { lists.moved.push_back(place(at, cell)); });
    }

    // Only pixels that have moved have a shift, and all of them are inside the image.
    std::erase_if(lists.moved, [&](PixelPlace at) {
      return !std::binary_search(lists.ever_moved.begin(), lists.ever_moved.end(), at);
    });
    sort_once(lists.moved);
  }

  static constexpr bool is_quick = requires(Field & field, std::span<ShiftedPixel> pixels) {
    field.hold_ballots(pixels, false);
  };

  Field& field_;
};

/// Cost of `order` at a pixel: minus twice its log-likelihood, up to a constant per pixel. Infinite
/// if the order is impossible.
using FringeOrderCost = std::function<double(int column, int row, int order)>;

/// Revises the fringe orders, each from the evidence of its pixel and of neighbours on the same
/// surface: those reachable through the window without crossing an edge of the wrapped phase, where
/// a choice here implies the order there. It infers nothing across edges. `wrapped_phase`: rad, [0,
/// 2 pi); `orders`: input, the pixels' own choices, and output; `lit`: 1 where the phase is valid.
void choose_with_neighbours(Image<int>& orders, const Image<double>& wrapped_phase,
                            const Image<std::uint8_t>& lit, const FringeOrderCost& cost);

}  // namespace slipstream
