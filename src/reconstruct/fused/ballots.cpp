#include "reconstruct/fused/ballots.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>

#include "decode/surface_window.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruct/fused/ballots.cpp"
#include <hwy/foreach_target.h>

#include "base/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// Bit mask of a window of five lines of five pixels, with eight bits per line. A line is one or
/// two vectors, whose last lanes are unused.
using Cells = std::uint64_t;
using LineTag = hn::CappedTag<float, 8>;
using WholeTag = hn::RebindToSigned<LineTag>;
using LineFloats = hn::Vec<LineTag>;
using LineMask = hn::Mask<LineTag>;

constexpr std::size_t line_pitch = 8, lanes = hn::MaxLanes(LineTag());
constexpr std::size_t per_line = line_pitch / lanes, vectors = 5 * per_line;
using Window = Several<vectors, LineFloats>;

constexpr Cells spread(std::uint32_t cells) {
  Cells found = 0;
  for (int line = 0; line < 5; ++line) found |= Cells{cells >> (5 * line) & 31U} << (8 * line);
  return found;
}

constexpr Cells whole_window = spread(WindowCells::whole_window);
constexpr Cells inner_window = spread(WindowCells::inner_window);
constexpr Cells middle = spread(WindowCells::bit(WindowCells::middle));

constexpr auto line_cells = [] {
  std::array<Cells, SurfaceWindow::line_cells.size()> sets{};
  for (std::size_t i = 0; i < sets.size(); ++i) sets[i] = spread(SurfaceWindow::line_cells[i]);
  return sets;
}();

/// Cells for which `test(k)`, a mask for vector k, is true.
template <class Test>
HWY_INLINE Cells cells_where(const Test& test) {
  Cells found = 0;

  each<vectors>([&](std::size_t k) SLIPSTREAM_STEP {
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(LineTag(), test(k), bits.data());
    found |= Cells{bits[0]} << (k * lanes);
  });
  return found;
}

/// The cells of vector k, as a mask.
HWY_INLINE LineMask mask_of(Cells cells, std::size_t k) {
  const WholeTag d;
  const auto bit = hn::Shl(hn::Set(d, 1), hn::Iota(d, 0));
  const auto set = hn::Set(d, static_cast<std::int32_t>(cells >> (k * lanes) & 255U));
  return hn::RebindMask(LineTag(), hn::TestBit(set, bit));
}

/// The surface of the middle pixel, and its neighbours (of four) on that surface.
struct Surface {
  Cells pixels, beside;
  bool winding = false;  ///< a shift's steps depend on the path
};

/// A pixel with its window.
class Ballot {
 public:
  HWY_INLINE Ballot(const BallotRows& rows, PixelPlace at)
      : rows_(rows), f_h_(hn::Set(LineTag(), rows.periods)) {
    // Where each line of the window begins in the ring of kept rows.
    for (int line = 0; line < 9; ++line) {
      const int row = (at.row + line - 4) & (rows.kept_rows - 1);
      places_[line] = row * rows.stride + at.column - 2;
    }

    // Phases relative to the pixel's own, as whole periods and the rest.
    own_ = hn::Set(LineTag(), rows.coordinate[places_[4] + 2]);
    each<vectors>([&](std::size_t k) SLIPSTREAM_STEP {
      const LineFloats p = periods(k, 0, 0);
      whole_[k] = hn::Round(p);
      part_[k] = hn::Sub(p, whole_[k]);
    });
  }

  [[nodiscard]] HWY_INLINE int chosen_shift() const {
    const Surface surface = surface_in<whole_window>();
    if (surface.winding) return undecided;
    const Window implied = implied_shifts();

    // 1. The choices: the pixel's own order, at no cost, and those one or two periods away.
    const std::ptrdiff_t at = places_[4] + 2;
    std::array<Choice, choice_count> choices{};
    for (std::size_t k = 0; k < order_shifts.size(); ++k) {
      choices[k + 1] = {.shift = order_shifts[k], .against = rows_.costs[k][at]};
    }

    // 2. Who votes for each. A pixel that agrees with its neighbours on the surface keeps its
    // shift.
    Cells others = surface.pixels;
    for (Choice& choice : choices) {
      choice.voters = surface.pixels & cells_where([&](std::size_t k) SLIPSTREAM_STEP {
                        return hn::Eq(implied[k], shift(choice));
                      });
      others &= ~choice.voters;
      if ((choice.voters & middle) != 0 && (surface.beside & ~choice.voters) == 0) {
        return choice.shift;
      }
    }

    // 3. Votes for an order with no stored cost are left to the exact rules.
    if (others != 0) return undecided;
    return least_cost_shift(surface.pixels, choices);
  }

  [[nodiscard]] HWY_INLINE int shift_unless_supported() const {
    const Surface surface = surface_in<inner_window>();
    if (surface.winding) return undecided;

    const Window implied = implied_shifts();
    const Cells content = cells_where(
        [&](std::size_t k) SLIPSTREAM_STEP { return hn::Eq(implied[k], hn::Zero(LineTag())); });

    return (content & surface.pixels & ~middle) != 0 ? 0 : 1;
  }

 private:
  /// A shift implied by some pixels of the window, and its cost for the middle pixel.
  struct Choice {
    int shift = 0;
    float against = 0;
    Cells voters = 0;
  };

  static constexpr std::size_t choice_count = order_shifts.size() + 1;  ///< the own order first

  [[nodiscard]] HWY_INLINE std::ptrdiff_t place(std::size_t k, int dx, int dy) const {
    return places_[k / per_line + 2 + static_cast<std::size_t>(dy)] +
           static_cast<std::ptrdiff_t>(k % per_line * lanes) + dx;
  }

  /// As in PhaseWindow: differences of coordinates are exact, and contraction is off in this file.
  [[nodiscard]] HWY_INLINE LineFloats periods(std::size_t k, int dx, int dy) const {
    const LineFloats y = hn::LoadU(LineTag(), rows_.coordinate + place(k, dx, dy));
    return hn::Mul(f_h_, hn::Sub(y, own_));
  }

  /// Shifts of the middle pixel that each pixel of the window implies.
  [[nodiscard]] HWY_INLINE Window implied_shifts() const {
    if (rows_.shift == nullptr) return whole_;

    const hn::Rebind<std::int16_t, LineTag> halves;
    Window implied;
    each<vectors>([&](std::size_t k) SLIPSTREAM_STEP {
      const auto shift = hn::LoadU(halves, rows_.shift + place(k, 0, 0));
      implied[k] = hn::Add(whole_[k], hn::ConvertTo(LineTag(), hn::PromoteTo(WholeTag(), shift)));
    });

    return implied;
  }

  /// Cells whose step to the next, without whole periods, is small. If all are, any two steps
  /// differ by less than `roughest`, so that all cells are linked.
  template <int dx, int dy>
  [[nodiscard]] HWY_INLINE Cells flat_links() const {
    const LineTag d;
    return cells_where([&](std::size_t k) SLIPSTREAM_STEP {
      LineFloats next;
      if constexpr (dy != 0) {
        next = part_[k + per_line < vectors ? k + per_line : k];
      } else {
        const LineFloats p = periods(k, 1, 0);
        next = hn::Sub(p, hn::Round(p));
      }

      return hn::Le(hn::Abs(hn::Sub(next, part_[k])), hn::Set(d, 0.0249F));
    });
  }

  /// SurfaceWindow::Steps; `plain`: the shift's step is the one of whole periods.
  struct Links {
    Cells linked, plain;
  };

  template <int dx, int dy>
  [[nodiscard]] HWY_INLINE Links links() const {
    const LineTag d;
    const LineFloats most = hn::Set(d, static_cast<float>(SurfaceWindow::steepest));
    const LineFloats rough = hn::Set(d, static_cast<float>(SurfaceWindow::roughest));

    Window next, whole;
    const Cells linked = cells_where([&](std::size_t k) SLIPSTREAM_STEP {
      const auto part = [](LineFloats step)
                            SLIPSTREAM_STEP { return hn::Sub(step, hn::Round(step)); };

      // The step to the next pixel, less whole periods, and the steps before and after it.
      const LineFloats at = periods(k, 0, 0);
      next[k] = periods(k, dx, dy);
      const LineFloats step = hn::Sub(next[k], at);
      whole[k] = hn::Round(step);
      const LineFloats here = hn::Sub(step, whole[k]);
      const LineFloats before = part(hn::Sub(at, periods(k, -dx, -dy)));
      const LineFloats after = part(hn::Sub(periods(k, 2 * dx, 2 * dy), next[k]));

      // On a smooth surface the step resembles at least one of the two beside it, if any exists.
      const auto near = [&](LineFloats other) SLIPSTREAM_STEP {
        return hn::Le(hn::Abs(hn::Sub(here, other)), rough);
      };
      const auto alone = hn::And(hn::IsNaN(before), hn::IsNaN(after));
      return hn::And(hn::Le(hn::Abs(here), most), hn::Or(alone, hn::Or(near(before), near(after))));
    });

    return {linked, cells_where([&](std::size_t k) SLIPSTREAM_STEP {
              return hn::Eq(whole[k], hn::Sub(hn::Round(next[k]), whole_[k]));
            })};
  }

  template <Cells window>
  [[nodiscard]] HWY_INLINE Surface surface_in() const {
    constexpr Cells right_links = window & (window >> 1), down_links = window & (window >> 8);

    // Most windows are flat: all of it is one surface.
    if ((~flat_links<1, 0>() & right_links) == 0 && (~flat_links<0, 1>() & down_links) == 0) {
      return {window, middle << 1 | middle >> 1 | middle << 8 | middle >> 8};
    }

    // Otherwise spread from the middle across the links until no pixel is added. A link has the
    // number of its left or upper pixel.
    const Links to_right = links<1, 0>(), downward = links<0, 1>();
    const Cells right = to_right.linked & right_links, down = downward.linked & down_links;
    const auto reached = [&](Cells from) SLIPSTREAM_STEP {
      return from | (from & right) << 1 | (from >> 1 & right) | (from & down) << 8 |
             (from >> 8 & down);
    };

    const Cells beside = reached(middle);
    Cells pixels = middle;
    for (Cells more = beside; more != pixels; more = reached(pixels)) pixels = more;

    // Links at which the step in shifts is not the difference of whole periods.
    const Cells winding = (right & ~to_right.plain & pixels & (pixels >> 1)) |
                          (down & ~downward.plain & pixels & (pixels >> 8));

    return {pixels, beside & ~middle, winding != 0};
  }

  static HWY_INLINE LineFloats shift(const Choice& choice) {
    return hn::Set(LineTag(), static_cast<float>(choice.shift));
  }

  /// Cost of a choice for a vector of pixels; their orders must be among order_shifts, or their
  /// own.
  [[nodiscard]] HWY_INLINE LineFloats costs(const Choice& choice, std::size_t k) const {
    const LineTag d;
    const LineFloats order = hn::Sub(shift(choice), whole_[k]);
    LineFloats found = hn::Zero(d);

    for (std::size_t i = 0; i < order_shifts.size(); ++i) {
      const LineFloats cost = hn::LoadU(d, rows_.costs[i] + place(k, 0, 0));
      const auto is_it = hn::Eq(order, hn::Set(d, static_cast<float>(order_shifts[i])));
      found = hn::IfThenElse(is_it, cost, found);
    }

    return found;
  }

  template <class Cost>
  static HWY_INLINE float sum_over(Cells cells, const Cost& cost) {
    LineFloats sum = hn::Zero(LineTag());
    each<vectors>([&](std::size_t k) SLIPSTREAM_STEP {
      sum = hn::Add(sum, hn::IfThenElseZero(mask_of(cells, k), cost(k)));
    });

    return hn::GetLane(hn::SumOfLanes(LineTag(), sum));
  }

  [[nodiscard]] HWY_INLINE int least_cost_shift(Cells surface,
                                                std::array<Choice, choice_count>& choices) const {
    const LineTag d;
    const Choice* best = nullptr;
    float least = std::numeric_limits<float>::infinity(), next = least;

    for (Choice& choice : choices) {
      // Leave out choices without a vote, and those that the pixel itself excludes.
      if (choice.voters == 0 || choice.against > static_cast<float>(VoteLimits::sure)) {
        choice.voters = 0;
        continue;
      }

      // No cost is stored for shifts further than those of order_shifts.
      const Cells far = cells_where([&](std::size_t k) SLIPSTREAM_STEP {
        constexpr auto farthest = static_cast<float>(order_shifts.back());
        return hn::Gt(hn::Abs(hn::Sub(shift(choice), whole_[k])), hn::Set(d, farthest));
      });
      if ((far & surface) != 0) return undecided;

      // The choice's cost for the pixel, for the rest of its surface, and for each dissenting vote.
      const float shares = sum_over(surface & ~middle, [&](std::size_t k) SLIPSTREAM_STEP {
        return hn::Min(costs(choice, k), hn::Set(d, static_cast<float>(VoteLimits::most_evidence)));
      });
      const float total = choice.against + shares +
                          static_cast<float>(VoteLimits::disagreement) *
                              static_cast<float>(std::popcount(surface & ~middle & ~choice.voters));

      // Keep the least and the second least.
      next = std::min(next, std::max(least, total));
      if (!(total < least)) continue;
      least = total;
      best = &choice;
    }

    // Too close a result, or a line that may override it, is left to the exact rules.
    if (best == nullptr) return 0;
    constexpr float rounding = 1e-3F;  // ten times the rounding of sums of 25 numbers up to 4
    if (!(next - least >= rounding)) return undecided;

    for (const Choice& choice : choices) {
      if (&choice != best && may_speak(surface, *best, choice)) return undecided;
    }

    return best->shift;
  }

  /// False only if no line can have enough evidence for a choice against the best one: all cells
  /// together save at least as much as the cells of a line.
  [[nodiscard]] HWY_INLINE bool may_speak(Cells surface, const Choice& best,
                                          const Choice& choice) const {
    const Cells others = choice.voters & ~middle;
    if (std::popcount(others) < 2) return false;

    // The factor allows for the rounding of the sum.
    const float saved = sum_over(surface, [&](std::size_t k) SLIPSTREAM_STEP {
      return hn::Max(hn::Sub(costs(best, k), costs(choice, k)), hn::Zero(LineTag()));
    });
    if (saved < 0.999F * static_cast<float>(VoteLimits::enough_along_a_line)) return false;

    for (const Cells line : line_cells) {
      if (std::popcount(line & others) >= 2) return true;
    }

    return false;
  }

  const BallotRows& rows_;
  std::array<std::ptrdiff_t, 9> places_;
  LineFloats f_h_, own_;
  Window whole_, part_;
};

void HoldBallots(const BallotRows& rows, std::span<ShiftedPixel> pixels, bool restores) {
  for (auto& [at, shift] : pixels) {
    const Ballot ballot(rows, at);
    shift = restores ? ballot.shift_unless_supported() : ballot.chosen_shift();
  }
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(HoldBallots);

void hold_ballots(const BallotRows& rows, std::span<ShiftedPixel> pixels, bool restores) {
  HWY_DYNAMIC_DISPATCH(HoldBallots)(rows, pixels, restores);
}

}  // namespace slipstream
#endif
