#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <tbb/global_control.h>

#include "app/commands.h"
#include "app/report_facts.h"
#include "bench/bench_report.h"
#include "bench/bench_rows.h"
#include "io/file.h"
#include "io/image_file.h"
#include "paper/reproduction.h"
#include "reconstruct/gpu.h"

namespace slipstream::app {
namespace {

struct BenchFlags {
  bool quick = false;
  bool gpu = false;
};

nlohmann::json json_of(const TimedRow& timed, double bandwidth) {
  const auto& [row, timing] = timed;
  nlohmann::json document =
      described("name", row.name, "steps", row.steps, "width", row.width, "height", row.height,
                "threads", row.threads, "ms", timing.median, "ms_quartiles",
                std::array{timing.lower_quartile, timing.upper_quartile}, "runs", timing.runs,
                "fps", timed.runs_per_second());

  if (row.bytes_per_pixel > 0) document["bytes_per_pixel"] = row.bytes_per_pixel;
  if (row.bytes_per_pixel > 0 && !row.is_beside_gpu) {
    document["bandwidth_share"] = timed.bytes_per_second() / bandwidth;
  }

  return document;
}

nlohmann::json json_of(const BenchReport& report) {
  const BenchMachine& machine = report.machine;
  const auto row = [&](const TimedRow& timed) { return json_of(timed, machine.bandwidth); };

  const auto published = [](const PublishedMark& mark) {
    return described("source", mark.source, "fps", mark.fps);
  };

  nlohmann::json ratios = report.ratios.over_fused;
  describe(ratios, "largest_per_pixel", report.ratios.largest_per_pixel, "threads",
           report.ratios.threads);

  nlohmann::json document =
      described("machine", machine.processor, "vectors", machine.vectors, "bandwidth_bytes_per_s",
                machine.bandwidth, "ratios", ratios, "rows", as_json(report.rows, row), "published",
                as_json(published_marks, published));

  if (!report.gpu.empty()) document["gpu"] = report.gpu;
  return document;
}

void bench(const BenchFlags& flags, Output& output) {
  BenchSettings settings;
  TimingSettings timing;

  using Threads = tbb::global_control;  // limited by --threads
  settings.most_threads = static_cast<int>(Threads::active_value(Threads::max_allowed_parallelism));

  // Quick: N = 3 and 640 x 480 only, one round, no minimum time per row.
  if (flags.quick) {
    settings.steps = {3};
    settings.enlargements = {1};
    settings.small = {};
    timing = {.rounds = 1, .row_seconds = 0};
  }

  BenchReport report{.machine = bench_machine()};
  output.say_lines(text_of(report.machine));

  if (flags.gpu) {
    const auto device = Gpu::open(std::nullopt);
    report.gpu = fmt::format("{}, {}", device->description().name, device->description().driver);
    output.say("GPU: {}", report.gpu);
  }

  const std::vector<BenchRow> rows = flags.gpu ? gpu_rows(settings) : bench_rows(settings);
  Progress progress("rows", timing.rounds * rows.size());
  report.rows = timed(rows, timing, [&] { progress.advance(); });
  progress.finish();

  report.ratios = bench_ratios(report.rows);
  output.say_lines(text_of(report));
  output.document = json_of(report);
}

struct ReproduceFlags {
  std::vector<std::string> names;
  bool list = false;
  std::string plots;
  std::string report;
  std::uint64_t seed = 1;
};

Reproduced run(const Reproducible& item, const ReproduceFlags& flags) {
  Reproduced done{item, item.run(flags.seed)};
  if (flags.plots.empty()) return done;

  for (const auto& [name, write] : done.result.plots) {
    done.plots.push_back(fs::path(flags.plots) / (name + ".png"));
    write(done.plots.back());
  }
  return done;
}

void reproduce(const ReproduceFlags& flags, Output& output) {
  throw_if(flags.names.empty() && !flags.list,
           "name what to recompute, e.g. table-4.1, or all; --list prints the names");
  const std::vector<Reproducible> items = reproducibles_named(flags.names);

  if (flags.list) {
    for (const Reproducible& item : items) {
      output.say("{:12} {}", item.name(), item.title);
      output.list("names").push_back(item.name());
    }
    return;
  }

  if (!flags.plots.empty()) make_folder(flags.plots);

  // Only with --report: std::filesystem::absolute throws for an empty path.
  const fs::path report_folder =
      flags.report.empty() ? fs::path() : fs::absolute(flags.report).parent_path();

  for (const char* kind : {"tables", "figures", "sections", "experiments"}) {
    output.document[kind] = nlohmann::json::array();
  }

  output.document["seed"] = flags.seed;
  Page report("Published and recomputed");
  Progress progress("reproduce", items.size());
  for (const Reproducible& item : items) {
    // Cells of the table, plots and notes, as JSON and in the report.
    const Reproduced done = run(item, flags);
    const auto cells = as_json(done.result.cells, [](const ReproducedCell& cell) {
      return described("quantity", cell.quantity, "parameters", cell.parameters, "published",
                       as_json(cell.published), "recomputed", as_json(cell.recomputed), "improved",
                       as_json(cell.improved));
    });
    const auto plots = as_json(done.plots, [](const fs::path& plot) { return plot.string(); });
    output.add_to(std::string(item.kind) + "s", "id", item.id, "title", item.title, "cells", cells,
                  "plots", plots, "notes", done.result.notes);

    if (!flags.report.empty()) add_to(report, done, report_folder);
    progress.advance();
    output.say_lines(text_of(done));
  }

  progress.finish();
  if (!flags.report.empty()) {
    report.heading("Run");
    report.facts(facts_of_run(output));
    write_page(flags.report, report);
    output.say("report: {}", flags.report);
  }
}

}  // namespace

void add_reproduce(const Commands& program) {
  const auto [command, flags] =
      program.add(reproduce, "reproduce",
                  "recompute the dissertation's tables and figures beside the published values");
  command.add("names", flags.names,
              "what to recompute, e.g. table-4.1 figure-4.7 section-4.5, or all");
  command.add("--list", flags.list, "list tables, figures and sections");
  command.add_output("--plots", flags.plots, "folder for the figures (PNG)", output_folder_type);
  command.add_output("--report", flags.report, "report with all plots: .html");
  command.add("--seed", flags.seed, "seed of the simulated noise");
  command.examples(
      {"reproduce table-4.1 figure-4.7 section-4.5 --plots plots --report report.html"});
}

void add_bench(const Commands& program) {
  const auto [command, flags] =
      program.add(bench, "bench", "time every stage on this machine, beside other implementations");
  command.add("--quick", flags.quick, "only N = 3 and 640x480, one run per row");
  command.add("--gpu", flags.gpu, "only compare the first GPU with the fused pass on all threads");
  command.examples({"bench", "bench --json > bench.json"},
                   "Compare ratios within one run rather than times between runs: other load on "
                   "the machine slows all rows.");
}

}  // namespace slipstream::app
