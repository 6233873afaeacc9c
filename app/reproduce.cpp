#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/output.h"
#include "slipstream/io/file.h"
#include "slipstream/io/plot.h"
#include "tools/reproduce/report.h"
#include "tools/reproduce/reproduction.h"

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

nlohmann::json json_of(const Reproduced& done) {
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

Reproduced run(const Reproducible& item, const ReproduceFlags& flags) {
  Reproduced done{item, item.run(flags.seed)};
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
      output.list("names").push_back(item.name());
    }
    return;
  }
  if (!flags.plots.empty()) make_folder(flags.plots);
  if (!flags.report.empty()) make_folder(fs::absolute(flags.report).parent_path());
  for (const char* kind : {"tables", "figures", "sections", "experiments"}) {
    output.document[kind] = nlohmann::json::array();
  }
  output.document["seed"] = flags.seed;
  std::string report = "# Published and recomputed\n\n";
  Progress progress("reproduce", static_cast<int>(items.size()));
  for (const Reproducible& item : items) {
    const Reproduced done = run(item, flags);
    output.list(std::string(item.kind) + "s").push_back(json_of(done));
    report += markdown_of(done, fs::path(flags.report).parent_path());
    progress.advance();
    output.say("{}", text_of(done));
  }
  progress.finish();
  if (!flags.report.empty()) {
    write_file(flags.report, report);
    output.say("report: {}", flags.report);
  }
}

}  // namespace

void add_reproduce(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, reproduce, "reproduce",
                  "the dissertation's tables and figures: published beside recomputed");
  command.add("names", flags.names, "as table-4.1 figure-4.7 section-4.5, or all");
  command.add("--list", flags.list, "say what there is");
  command.add("--plots", flags.plots, "folder for the figures as PNG");
  command.add_output("--report", flags.report, "a Markdown report: .md");
  command.add("--seed", flags.seed, "of the simulated noise");
  command.app.footer(
      "Example:\n  slipstream reproduce table-4.1 figure-4.7 section-4.5 --plots plots --report "
      "report.md");
}

}  // namespace slipstream::app
