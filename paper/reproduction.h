#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/page.h"
#include "io/image_file.h"
#include "io/plot.h"

namespace slipstream {

/// One number of the dissertation and of slipstream.
struct ReproducedCell {
  std::string quantity;                                    ///< with its unit
  std::vector<std::pair<std::string, double>> parameters;  ///< "N" 3, "gamma" 3.18
  /// As printed, or from the equation if a note says so.
  std::optional<double> published;
  std::optional<double> recomputed;  ///< by the published rule
  std::optional<double> improved;    ///< by slipstream's rule
};

/// A plot with its file name, without extension: "figure-4.7-error".
struct NamedPlot {
  std::string name;
  std::function<void(const std::filesystem::path& file)> write;
};

/// A recomputed table, figure or section.
struct Reproduction {
  std::vector<ReproducedCell> cells;
  std::vector<NamedPlot> plots;
  std::vector<std::string> notes;  ///< facts about the numbers, one sentence each

  void add(std::string quantity, std::vector<std::pair<std::string, double>> parameters,
           std::optional<double> published, std::optional<double> recomputed,
           std::optional<double> improved = std::nullopt) {
    cells.push_back({std::move(quantity), std::move(parameters), published, recomputed, improved});
  }
  /// Adds a line or bar plot.
  template <class Plot>
  void draw(std::string name, Plot plot) {
    plots.push_back({std::move(name), [plot = std::move(plot)](const std::filesystem::path& file) {
                       write_plot(file, plot);
                     }});
  }
  /// Adds a map in colours, with a scale.
  void draw_map(std::string name, Image<double> map, std::string unit) {
    plots.push_back({std::move(name), [map = std::move(map),
                                       unit = std::move(unit)](const std::filesystem::path& file) {
                       write_map_preview(file, map, unit);
                     }});
  }
  /// Adds a grey picture as it is.
  void draw_picture(std::string name, Image<std::uint8_t> picture) {
    plots.push_back(
        {std::move(name), [picture = std::move(picture)](const std::filesystem::path& file) {
           write_image(file, picture);
         }});
  }
  /// Adds a line plot.
  void draw(std::string name, std::string title, std::string x, std::string y, PlotScale scale,
            std::vector<PlotLine> lines) {
    draw(std::move(name),
         LinePlot{std::move(title), std::move(x), std::move(y), scale, std::move(lines)});
  }
};

/// A table, figure, section or experiment that can be recomputed.
struct Reproducible {
  std::string_view kind;   ///< "table", "figure", "section", or, not in the paper, "experiment"
  std::string_view id;     ///< its number: "4.1", or name
  std::string_view title;  ///< short
  std::function<Reproduction(std::uint64_t seed)> run;

  /// "table-4.1".
  [[nodiscard]] std::string name() const { return std::string(kind) + "-" + std::string(id); }
};

/// All, in the order of the dissertation.
std::vector<Reproducible> reproducibles();

/// Finds items by name, in the order of the dissertation; all of them for "all" or no name. A name
/// that ends in "-N.", such as "figure-4.", selects all that begin with it. Throws Error for an
/// unknown name.
std::vector<Reproducible> reproducibles_named(const std::vector<std::string>& names);

/// A finished item, with its plot files.
struct Reproduced {
  Reproducible item;
  Reproduction result;
  std::vector<std::filesystem::path> plots{};
};

/// Text for a terminal: name, then a line for each cell, note and plot.
std::string text_of(const Reproduced& reproduced);

/// Adds a section to a page in `folder`, an absolute path.
void add_to(Page& page, const Reproduced& reproduced, const std::filesystem::path& folder);

}  // namespace slipstream
