#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "slipstream/io/plot.h"

namespace slipstream {

/// One number of the dissertation beside slipstream's.
struct ReproducedCell {
  std::string quantity;                                    ///< with its unit
  std::vector<std::pair<std::string, double>> parameters;  ///< "N" 3, "gamma" 3.18
  /// As printed; where a note says so, what its equation gives.
  std::optional<double> published;
  std::optional<double> recomputed;  ///< by the published rule
  std::optional<double> improved;    ///< by slipstream's own
};

/// A plot with the name of its file, without ending: "figure-4.7-error".
struct NamedPlot {
  std::string name;
  Plot plot;
};

/// A table, figure or section recomputed.
struct Reproduction {
  std::vector<ReproducedCell> cells;
  std::vector<NamedPlot> plots;
  std::vector<std::string> notes;  ///< what a reader of the numbers should know, a sentence each

  void add(std::string quantity, std::vector<std::pair<std::string, double>> parameters,
           std::optional<double> published, std::optional<double> recomputed,
           std::optional<double> improved = std::nullopt) {
    cells.push_back({std::move(quantity), std::move(parameters), published, recomputed, improved});
  }
  /// A plot of lines.
  void draw(std::string name, std::string title, std::string x, std::string y, PlotScale scale,
            std::vector<PlotLine> lines) {
    plots.push_back({std::move(name), LinePlot{std::move(title), std::move(x), std::move(y), scale,
                                               std::move(lines)}});
  }
};

/// Something that can be recomputed.
struct Reproducible {
  std::string_view kind;   ///< "table", "figure" or "section"; "experiment": none of the paper's
  std::string_view id;     ///< its number: "4.1", or name
  std::string_view title;  ///< in a few words
  std::function<Reproduction(std::uint64_t seed)> run;

  /// "table-4.1".
  [[nodiscard]] std::string name() const { return std::string(kind) + "-" + std::string(id); }
};

/// All of them, in the order of the dissertation.
std::vector<Reproducible> reproducibles();

/// Those of the names given, in the order of the dissertation; all of them for "all" or no name. A
/// name that ends in "-N." as "figure-4." takes all that begin so. Throws Error for a name that is
/// none.
std::vector<Reproducible> reproducibles_named(const std::vector<std::string>& names);

/// Chapter 4: see reproducibles().
std::vector<Reproducible> gamma_reproducibles();

/// Depth errors of a sphere and a statue that move, by speed, frames and weights.
std::vector<Reproducible> motion_reproducibles();

/// How far the model of an object that turns once is from the object.
std::vector<Reproducible> model_reproducibles();

}  // namespace slipstream
