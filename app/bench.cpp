#include <vector>

#include <tbb/global_control.h>

#include "app/commands.h"
#include "app/output.h"
#include "slipstream/reconstruct/gpu.h"
#include "tools/bench/bench_report.h"
#include "tools/bench/bench_rows.h"

namespace slipstream::app {
namespace {

struct BenchFlags {
  bool quick = false;
  bool gpu = false;
};

nlohmann::json json_of(const TimedRow& timed, double bandwidth) {
  const auto& [row, timing] = timed;
  nlohmann::json document{{"name", row.name},
                          {"steps", row.steps},
                          {"width", row.width},
                          {"height", row.height},
                          {"threads", row.threads},
                          {"ms", timing.median},
                          {"ms_quartiles", {timing.lower_quartile, timing.upper_quartile}},
                          {"runs", timing.runs},
                          {"fps", timed.runs_per_second()}};
  if (row.bytes_per_pixel > 0) document["bytes_per_pixel"] = row.bytes_per_pixel;
  if (row.bytes_per_pixel > 0 && !row.is_beside_gpu) {
    document["bandwidth_share"] = timed.bytes_per_second() / bandwidth;
  }
  return document;
}

nlohmann::json json_of(const BenchRatios& ratios) {
  nlohmann::json document = ratios.over_fused;
  if (ratios.largest_per_pixel) document["largest_per_pixel"] = *ratios.largest_per_pixel;
  if (ratios.threads) document["threads"] = *ratios.threads;
  return document;
}

nlohmann::json json_of(const BenchReport& report) {
  const BenchMachine& machine = report.machine;
  nlohmann::json document{{"machine", machine.processor},
                          {"vectors", machine.vectors},
                          {"bandwidth_bytes_per_s", machine.bandwidth},
                          {"ratios", json_of(report.ratios)},
                          {"rows", nlohmann::json::array()},
                          {"published", nlohmann::json::array()}};
  if (!report.gpu.empty()) document["gpu"] = report.gpu;
  for (const TimedRow& timed : report.rows) {
    document["rows"].push_back(json_of(timed, machine.bandwidth));
  }
  for (const PublishedMark& mark : published_marks) {
    document["published"].push_back({{"source", mark.source}, {"fps", mark.fps}});
  }
  return document;
}

void bench(const BenchFlags& flags, Output& output) {
  BenchSettings settings;
  TimingSettings timing;
  using Threads = tbb::global_control;  // as --threads limits them
  settings.most_threads = static_cast<int>(Threads::active_value(Threads::max_allowed_parallelism));
  if (flags.quick) {
    settings.steps = {3};
    settings.enlargements = {1};
    settings.small = {};
    timing = {.rounds = 1, .row_seconds = 0};
  }
  BenchReport report{.machine = bench_machine()};
  output.say("{}", text_of(report.machine));
  if (flags.gpu) {
    const auto device = Gpu::open(std::nullopt);
    report.gpu = fmt::format("{}, {}", device->description().name, device->description().driver);
    output.say("GPU: {}", report.gpu);
  }
  const std::vector<BenchRow> rows = flags.gpu ? gpu_rows(settings) : bench_rows(settings);
  Progress progress("rows", timing.rounds * static_cast<int>(rows.size()));
  report.rows = timed(rows, timing, [&] { progress.advance(); });
  progress.finish();
  report.ratios = bench_ratios(report.rows);
  output.say("{}", text_of(report));
  output.document = json_of(report);
}

}  // namespace

void add_bench(CLI::App& program, Command& chosen) {
  const auto [command, flags] = add_command(
      program, chosen, bench, "bench", "times of every stage on this machine, and of its peers");
  command.add("--quick", flags.quick, "N = 3 and 640x480 alone, one run of each row");
  command.add("--gpu", flags.gpu,
              "the first GPU beside the fused pass on all threads, and nothing else");
  command.app.footer(
      "Examples:\n  slipstream bench\n  slipstream bench --json > bench.json\nRatios within one "
      "run hold better than times from run to run: other work on the machine slows all rows.");
}

}  // namespace slipstream::app
