#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/progress.h"
#include "slipstream/io/file.h"
#include "slipstream/io/plot_file.h"
#include "slipstream/reproduce/reproduction.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct ReproduceFlags {
  std::vector<std::string> names;
  bool list = false;
  std::string plots;
  std::string report;
  std::uint64_t seed = 1;
};

/// One that has been run, with the files of its plots.
struct Done {
  Reproducible item;
  Reproduction result;
  std::vector<fs::path> plots;
};

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

nlohmann::json json_of(const Done& done) {
  nlohmann::json document{{"id", done.item.id},
                          {"title", done.item.title},
                          {"cells", nlohmann::json::array()},
                          {"plots", nlohmann::json::array()},
                          {"notes", done.result.notes}};
  for (const ReproducedCell& cell : done.result.cells) {
    nlohmann::json parameters = nlohmann::json::object();
    for (const auto& [name, value] : cell.parameters) parameters[name] = value;
    nlohmann::json entry{{"quantity", cell.quantity}, {"parameters", parameters}};
    const auto set = [&](const char* name, const std::optional<double>& value) {
      entry[name] = value ? nlohmann::json(*value) : nlohmann::json(nullptr);
    };
    set("published", cell.published);
    set("recomputed", cell.recomputed);
    set("improved", cell.improved);
    document["cells"].push_back(std::move(entry));
  }
  for (const fs::path& plot : done.plots) document["plots"].push_back(plot.string());
  return document;
}

/// A section of the Markdown report; pictures relative to its folder.
std::string markdown_of(const Done& done, const fs::path& folder) {
  std::string text = fmt::format("## {}: {}\n\n", done.item.name(), done.item.title);
  if (!done.result.cells.empty()) {
    text +=
        "| quantity | of | published | recomputed | improved |\n| --- | --- | --- | --- | --- |\n";
    for (const ReproducedCell& cell : done.result.cells) {
      text +=
          fmt::format("| {} | {} | {} | {} | {} |\n", cell.quantity, text_of(cell.parameters),
                      text_of(cell.published), text_of(cell.recomputed), text_of(cell.improved));
    }
    text += "\n";
  }
  for (const std::string& note : done.result.notes) text += note + "\n\n";
  for (const fs::path& plot : done.plots) {
    text +=
        fmt::format("![{}]({})\n\n", plot.stem().string(),
                    fs::absolute(plot).lexically_proximate(fs::current_path() / folder).string());
  }
  return text;
}

void tell(const Done& done, Output& output) {
  output.say("{}: {}", done.item.name(), done.item.title);
  for (const ReproducedCell& cell : done.result.cells) {
    output.say("  {:52} {:40} published {:>9}  recomputed {:>9}{}", cell.quantity,
               text_of(cell.parameters), text_of(cell.published), text_of(cell.recomputed),
               cell.improved ? "  improved " + text_of(cell.improved) : "");
  }
  for (const std::string& note : done.result.notes) output.say("  {}", note);
  for (const fs::path& plot : done.plots) output.say("  {}", plot.string());
}

Done run(const Reproducible& item, const ReproduceFlags& flags) {
  Done done{item, item.run(flags.seed), {}};
  if (flags.plots.empty()) return done;
  for (const auto& [name, plot] : done.result.plots) {
    done.plots.push_back(fs::path(flags.plots) / (name + ".png"));
    write_plot(done.plots.back(), plot);
  }
  return done;
}

void reproduce(const ReproduceFlags& flags, Output& output) {
  const std::vector<Reproducible> items = reproducibles_named(flags.names);
  if (flags.list) {
    for (const Reproducible& item : items) {
      output.say("{:12} {}", item.name(), item.title);
      output.document["names"].push_back(item.name());
    }
    return;
  }
  if (!flags.plots.empty()) make_folder(flags.plots);
  if (!flags.report.empty()) make_folder(fs::absolute(flags.report).parent_path());
  for (const char* kind : {"tables", "figures", "sections"}) {
    output.document[kind] = nlohmann::json::array();
  }
  output.document["seed"] = flags.seed;
  std::string report = "# Published and recomputed\n\n";
  Progress progress("reproduce", static_cast<int>(items.size()));
  for (const Reproducible& item : items) {
    const Done done = run(item, flags);
    output.document[std::string(item.kind) + "s"].push_back(json_of(done));
    report += markdown_of(done, fs::path(flags.report).parent_path());
    progress.advance();
    tell(done, output);
  }
  progress.finish();
  if (!flags.report.empty()) {
    write_file(flags.report, report);
    output.say("report: {}", flags.report);
  }
}

}  // namespace

void add_reproduce(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command = program.add_subcommand(
      "reproduce", "the dissertation's tables and figures: published beside recomputed");
  const auto flags = std::make_shared<ReproduceFlags>();
  command->add_option("names", flags->names, "as table-4.1 figure-4.7 section-4.5, or all");
  command->add_flag("--list", flags->list, "say what there is");
  command->add_option("--plots", flags->plots, "folder for the figures as PNG");
  command->add_option("--report", flags->report, "a Markdown report: .md");
  command->add_option("--seed", flags->seed, "of the simulated noise")->capture_default_str();
  add_shared_flags(*command, shared);
  command->footer(
      "Example:\n  slipstream reproduce table-4.1 figure-4.7 section-4.5 --plots plots --report "
      "report.md");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { reproduce(*flags, output); }; });
}

}  // namespace slipstream::app
