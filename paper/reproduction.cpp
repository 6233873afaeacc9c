#include "paper/reproduction.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "paper/foam_board.h"
#include "paper/gamma_experiment.h"
#include "paper/gamma_model.h"
#include "paper/hand_figures.h"
#include "paper/harmonic_figures.h"
#include "paper/lookup_tables.h"
#include "paper/model_table.h"
#include "paper/motion_table.h"
#include "paper/multiplexing_tables.h"
#include "paper/noise_figures.h"
#include "paper/pcmp_figures.h"
#include "paper/phase_figures.h"
#include "slipstream/error.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

std::string text_of(const std::optional<double>& value) {
  return value ? fmt::format("{:.4g}", *value) : "";
}

std::string text_of(const std::vector<std::pair<std::string, double>>& parameters) {
  std::string text;
  for (const auto& [name, value] : parameters) {
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", name, value);
  }
  return text;
}

}  // namespace

std::vector<Reproducible> reproducibles() {
  std::vector<Reproducible> all;
  for (const auto& some :
       {phase_reproducibles(), harmonic_reproducibles(), lookup_table_reproducibles(),
        hand_reproducibles(), multiplexing_table_reproducibles(), noise_figure_reproducibles(),
        foam_board_reproducibles(), pcmp_figure_reproducibles(), gamma_model_reproducibles(),
        gamma_experiment_reproducibles(), motion_reproducibles(), model_reproducibles()}) {
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

std::vector<Reproducible> reproducibles_named(const std::vector<std::string>& names) {
  std::vector<Reproducible> all = reproducibles();
  if (names.empty() || std::find(names.begin(), names.end(), "all") != names.end()) return all;
  const auto means = [](const std::string& name, const Reproducible& item) {
    return name.ends_with('.') ? item.name().starts_with(name) : item.name() == name;
  };
  for (const std::string& name : names) {
    const bool known = std::any_of(all.begin(), all.end(),
                                   [&](const Reproducible& item) { return means(name, item); });
    if (!known) throw Error(fmt::format("unknown item '{}'; `list` prints all names", name));
  }
  std::erase_if(all, [&](const Reproducible& item) {
    return std::none_of(names.begin(), names.end(),
                        [&](const std::string& name) { return means(name, item); });
  });
  return all;
}

std::string text_of(const Reproduced& reproduced) {
  const auto& [item, result, plots] = reproduced;
  std::string text = fmt::format("{}: {}", item.name(), item.title);
  for (const ReproducedCell& cell : result.cells) {
    text += fmt::format("\n  {:52} {:40} published {:>9}  recomputed {:>9}{}", cell.quantity,
                        text_of(cell.parameters), text_of(cell.published), text_of(cell.recomputed),
                        cell.improved ? "  improved " + text_of(cell.improved) : "");
  }
  for (const std::string& note : result.notes) text += "\n  " + note;
  for (const fs::path& plot : plots) text += "\n  " + plot.string();
  return text;
}

void add_to(Page& page, const Reproduced& reproduced, const fs::path& folder) {
  const auto& [item, result, plots] = reproduced;
  page.heading(fmt::format("{}: {}", item.name(), item.title));
  if (!result.cells.empty()) {
    page.table({"quantity", "of", "published", "recomputed", "improved"});
  }
  for (const ReproducedCell& cell : result.cells) {
    page.row({cell.quantity, text_of(cell.parameters), text_of(cell.published),
              text_of(cell.recomputed), text_of(cell.improved)});
  }
  for (const std::string& note : result.notes) page.paragraph("{}", note);
  for (const fs::path& plot : plots) {
    page.picture(plot.stem().string(), fs::absolute(plot).lexically_proximate(folder).string());
  }
}

}  // namespace slipstream
