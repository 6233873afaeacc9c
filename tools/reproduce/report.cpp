#include "tools/reproduce/report.h"

#include <optional>
#include <utility>

#include <fmt/format.h>

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

std::string markdown_of(const std::vector<ReproducedCell>& cells) {
  std::string text =
      "| quantity | of | published | recomputed | improved |\n| --- | --- | --- | --- | --- |\n";
  for (const ReproducedCell& cell : cells) {
    text += fmt::format("| {} | {} | {} | {} | {} |\n", cell.quantity, text_of(cell.parameters),
                        text_of(cell.published), text_of(cell.recomputed), text_of(cell.improved));
  }
  return text + "\n";
}

}  // namespace

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

std::string markdown_of(const Reproduced& reproduced, const fs::path& folder) {
  const auto& [item, result, plots] = reproduced;
  std::string text = fmt::format("## {}: {}\n\n", item.name(), item.title);
  if (!result.cells.empty()) text += markdown_of(result.cells);
  for (const std::string& note : result.notes) text += note + "\n\n";
  for (const fs::path& plot : plots) {
    const fs::path near = fs::absolute(plot).lexically_proximate(fs::current_path() / folder);
    text += fmt::format("![{}]({})\n\n", plot.stem().string(), near.string());
  }
  return text;
}

}  // namespace slipstream
