#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace slipstream {

/// Phases in periods around a pixel: nine lines of nine, the pixel in the middle. The padding after
/// each nine and after the last line is for whole vectors and has no meaning.
struct PhaseWindow {
  static constexpr std::size_t line = 12;
  std::array<float, 10 * line> periods{};
};

/// A window of 5 x 5 pixels, numbered by rows; sets of them are bit masks.
struct WindowCells {
  static constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }
  static double nearest_whole(double periods) {
    constexpr double rounding = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds
    return (periods + rounding) - rounding;
  }

  static constexpr int side = 5, middle = 12, cells = side * side;
  using Cells = std::uint32_t;
  static constexpr Cells bit(int cell) { return Cells{1} << cell; }
  static constexpr Cells whole_window = (Cells{1} << cells) - 1;
  static constexpr Cells inner_window = 0b00000'01110'01110'01110'00000;
};

/// The pixels of a window on the surface of the middle one: those reachable without crossing an
/// edge of the wrapped phase.
struct SurfaceWindow : WindowCells {
  static constexpr double steepest = 0.25;  ///< periods per pixel; a step above it is an edge
  /// Periods; largest difference between a step and those before and after it.
  static constexpr double roughest = 0.05;

  /// Five pixels through the middle, straight or bent by one.
  using Line = std::array<int, side>;
  static constexpr auto lines = [] {
    std::array<Line, 20> found{};

    std::size_t count = 0;
    const auto add = [&](std::array<int, side> across) {
      Line down{}, right{};

      for (int i = 0; i < side; ++i) {
        down[index(i)] = side * i + 2 + across[index(i)];
        right[index(i)] = side * (2 + across[index(i)]) + i;
      }

      found[count++] = down;
      // The antidiagonal is its own mirror image, in reverse order.
      if (across[0] != 2 && across[0] != -2) found[count++] = right;
    };

    // Straight lines, diagonals, and lines with one bend on either side.
    add({0, 0, 0, 0, 0});
    for (const int sign : {-1, 1}) {
      add({2 * sign, sign, 0, -sign, -2 * sign});
      add({sign, sign, 0, 0, 0});
      add({0, 0, 0, sign, sign});
      add({sign, 0, 0, 0, 0});
      add({0, 0, 0, 0, sign});
    }

    return found;
  }();
  static constexpr auto line_cells = [] {
    std::array<Cells, lines.size()> sets{};
    for (std::size_t i = 0; i < sets.size(); ++i)
      for (const int cell : lines[i]) sets[i] |= bit(cell);

    return sets;
  }();

  /// Links between the pixels of a window and those to the right and below.
  struct Links {
    Cells right = 0, down = 0;
    std::array<int, cells> right_step, down_step;  ///< shift_step if linked
  };

  /// Steps through a window to the place `distance` further: the number of whole periods, and
  /// whether the surface continues across them. Separate loops, for vectorisation.
  template <std::size_t distance, std::size_t first, std::size_t last>
  struct Steps {
    std::array<float, last> whole, part;
    std::array<int, last> linked;

    explicit Steps(const PhaseWindow& window) {
      constexpr auto most = static_cast<float>(steepest), rough = static_cast<float>(roughest);
      constexpr float rounding = 12582912.0F;  // 1.5 * 2^23: adding it rounds
      const auto& periods = window.periods;

      // The whole periods of each step, and the rest.
      for (std::size_t i = first - distance; i < last; ++i) {
        const float step = periods[i + distance] - periods[i];
        whole[i] = (step + rounding) - rounding;
        part[i] = step - whole[i];
      }

      // A link needs a gentle step that resembles one beside it, if there is any.
      for (std::size_t i = first; i < last - distance; ++i) {
        const float before = part[i - distance], step = part[i], after = part[i + distance];

        // Integers, as && and || would branch.
        const int alone = int{before != before} & int{after != after};
        const int smooth =
            int{std::abs(step - before) <= rough} | int{std::abs(step - after) <= rough};

        linked[i] = (int{std::abs(step) <= most} & (alone | smooth)) != 0 ? 1 : 0;
      }
    }

    [[nodiscard]] int shift_step(std::size_t i) const {
      return linked[i] != 0 ? -static_cast<int>(whole[i]) : 0;
    }
  };

  static Links links_in(const PhaseWindow& window) {
    constexpr std::size_t line = PhaseWindow::line;
    const Steps<1, 2 * line + 2, 7 * line> right(window);
    const Steps<line, 2 * line, 7 * line> down(window);

    Links links;
    for (int row = 0, cell = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column, ++cell) {
        const std::size_t i = index(row + 2) * line + index(column + 2);
        if (column + 1 < side) {
          links.right |= static_cast<Cells>(right.linked[i]) << cell;
          links.right_step[index(cell)] = right.shift_step(i);
        }

        if (row + 1 < side) {
          links.down |= static_cast<Cells>(down.linked[i]) << cell;
          links.down_step[index(cell)] = down.shift_step(i);
        }
      }
    }

    return links;
  }

  /// Pixels on the surface of the middle, reached through the window, and their shifts relative to
  /// the middle's if they agree with it.
  struct Surface {
    Cells pixels = bit(middle);
    std::array<int, cells> shift_step{};
  };

  static Surface same_surface(const Links& links, Cells window) {
    Surface surface;
    // Grow the surface by one link at a time, in four directions.
    for (Cells front = bit(middle); front != 0;) {
      Cells reached = 0;
      const auto reach = [&](Cells from, int distance, const auto& steps, int sign) {
        Cells to = (distance > 0 ? from << distance : from >> -distance) & window &
                   ~surface.pixels & ~reached;

        reached |= to;
        for (; to != 0; to &= to - 1) {
          const int cell = std::countr_zero(to), parent = cell - distance;
          // A link has the number of the first of its pixels.
          const int link = sign > 0 ? parent : cell;
          surface.shift_step[index(cell)] =
              surface.shift_step[index(parent)] + sign * steps[index(link)];
        }
      };

      // Right, left, down, up.
      reach(front & links.right, 1, links.right_step, 1);
      reach(front & (links.right << 1), -1, links.right_step, -1);
      reach(front & links.down, side, links.down_step, 1);
      reach(front & (links.down << side), -side, links.down_step, -1);

      surface.pixels |= reached;
      front = reached;
    }

    return surface;
  }

  template <class Visit>
  static void for_each_cell(Cells set, const Visit& visit) {
    for (; set != 0; set &= set - 1) visit(std::countr_zero(set));
  }
};

}  // namespace slipstream
