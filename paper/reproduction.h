#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
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

/// One that has been run, with the files of its plots.
struct Reproduced {
  Reproducible item;
  Reproduction result;
  std::vector<std::filesystem::path> plots{};
};

/// What a terminal shows of it: its name, a line for each cell, note and plot.
std::string text_of(const Reproduced& reproduced);

/// Its section of a Markdown report that stands in `folder`; pictures relative to that.
std::string markdown_of(const Reproduced& reproduced, const std::filesystem::path& folder);

/// Tables 3.1 to 3.3 by the published rule and by the default one, and Tables 3.5 and 3.7 on the
/// virtual scanner, of Liu 2010.
std::vector<Reproducible> multiplexing_table_reproducibles();

/// Figures 3.1 to 3.3, 3.5, 3.7, 3.8, 3.10 and 3.11: noise, as predicted and as measured.
std::vector<Reproducible> noise_figure_reproducibles();

/// Table 4.1 and Figures 4.1 to 4.10: the gamma model without noise.
std::vector<Reproducible> gamma_model_reproducibles();

/// Sections 4.4 and 4.5: two cameras, and the experiments, on the virtual scanner.
std::vector<Reproducible> gamma_experiment_reproducibles();

/// Depth errors of a sphere and a statue that move, by speed, frames and weights.
std::vector<Reproducible> motion_reproducibles();

/// How far the model of an object that turns once is from the object.
std::vector<Reproducible> model_reproducibles();

}  // namespace slipstream
