#include <cstddef>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "tools/reproduce/multiplexing.h"
#include "tools/reproduce/unwrapping_tables.h"
#include "tools/reproduce/variance_ratio_tables.h"

namespace slipstream {
namespace {

constexpr auto smooth = UnwrappingTrial::Surface::smooth;
constexpr auto stepped = UnwrappingTrial::Surface::stepped;

ReproducedCell reproduced(const UnwrappingCell& cell, std::optional<double> published) {
  return {"pixels unwrapped rightly, %",
          {{"N", cell.steps}, {"alpha_p", cell.alpha_p}, {"c_1", cell.c1}, {"f_h", cell.high}},
          published,
          cell.recomputed,
          cell.improved};
}

Reproduction unwrapping(int steps, std::uint64_t seed) {
  Reproduction result;
  for (const UnwrappingCell& cell : unwrapping_table(steps, {.surface = smooth, .seed = seed})) {
    result.cells.push_back(reproduced(cell, cell.published));
  }
  return result;
}

Reproduction unwrapping_at_edges(std::uint64_t seed) {
  Reproduction result;
  std::size_t worse = 0;
  for (const int steps : {3, 4, 5}) {
    for (const UnwrappingCell& cell : unwrapping_table(steps, {.surface = stepped, .seed = seed})) {
      result.cells.push_back(reproduced(cell, std::nullopt));
      worse += cell.worse;
    }
  }
  result.notes.push_back(fmt::format(
      "Of the pixels of all 27 scans {} are unwrapped rightly by the published rule and wrongly by "
      "the default one.",
      worse));
  return result;
}

Reproduction variance_ratios(int steps, std::uint64_t seed) {
  const VarianceRatioTrial trial{.seed = seed};
  Reproduction result;
  std::vector<ReproducedCell> of_foam;
  for (const VarianceRatioCell& cell : variance_ratio_table(steps, trial)) {
    const auto add = [&](auto& cells, const char* quantity, double published, double recomputed) {
      cells.push_back({quantity,
                       {{"N", steps}, {"c_1", cell.c1}, {"f_h", cell.high}},
                       published,
                       recomputed,
                       {}});
    };
    add(result.cells, "variance of PMP over that of PCMP", cell.predicted, cell.measured);
    add(of_foam, "the same, of foam", cell.published, cell.of_foam);
  }
  result.cells.insert(result.cells.end(), of_foam.begin(), of_foam.end());
  result.notes.emplace_back(
      "Published: the theory, c_1^2 f_h^2; recomputed: a board before the virtual scanner, 8-bit "
      "frames.");
  result.notes.push_back(fmt::format(
      "Of foam: published the dissertation's experiment; recomputed with gamma {} and a "
      "board in which half of the light spreads by {} mm.",
      trial.gamma, trial.translucency));
  return result;
}

}  // namespace

std::vector<Reproducible> multiplexing_table_reproducibles() {
  const auto unwrapping_of = [](int steps) {
    return [steps](std::uint64_t seed) { return unwrapping(steps, seed); };
  };
  const auto ratios_of = [](int steps) {
    return [steps](std::uint64_t seed) { return variance_ratios(steps, seed); };
  };
  return {
      {"table", "3.1", "pixels unwrapped rightly by 3-pattern PCMP", unwrapping_of(3)},
      {"table", "3.2", "pixels unwrapped rightly by 4-pattern PCMP", unwrapping_of(4)},
      {"table", "3.3", "pixels unwrapped rightly by 5-pattern PCMP", unwrapping_of(5)},
      {"section", "3.2", "pixels unwrapped rightly by PCMP with depth edges", unwrapping_at_edges},
      {"table", "3.5", "variance of 4-step PMP over that of 4-pattern PCMP", ratios_of(4)},
      {"table", "3.7", "variance of 5-step PMP over that of 5-pattern PCMP", ratios_of(5)}};
}

}  // namespace slipstream
