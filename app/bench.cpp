#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/progress.h"
#include "slipstream/performance/bench_rows.h"
#include "slipstream/reconstruct/vector_target.h"

namespace slipstream::app {
namespace {

struct BenchFlags {
  bool quick = false;
};

/// Published clouds per second, frames to cloud, 640x480, N = 3.
struct PublishedMark {
  const char* source;
  int fps;
};
constexpr PublishedMark published_marks[] = {
    {"Liu 2010, one core of 2008", 173},
    {"the same author, Opt. Lett. 45(12), 2020", 492},
};

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

struct TimedRow {
  BenchRow row;
  Timing timing;

  [[nodiscard]] double bytes_per_second() const {
    return row.bytes_per_pixel * row.width * row.height / (1e-3 * timing.median);
  }
};

using TimedRows = std::vector<TimedRow>;

/// The row of that name, N and size on one thread; null where there is none.
const TimedRow* find(const TimedRows& rows, const std::string& name, int steps, int width = 640) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const TimedRow& timed) {
    return timed.row.name == name && timed.row.steps == steps && timed.row.width == width &&
           timed.row.threads == 1;
  });
  return found == rows.end() ? nullptr : &*found;
}

nlohmann::json json_of(const TimedRow& timed, double bandwidth) {
  nlohmann::json row{{"name", timed.row.name},
                     {"steps", timed.row.steps},
                     {"width", timed.row.width},
                     {"height", timed.row.height},
                     {"threads", timed.row.threads},
                     {"ms", timed.timing.median},
                     {"ms_quartiles", {timed.timing.lower_quartile, timed.timing.upper_quartile}},
                     {"runs", timed.timing.runs},
                     {"fps", 1e3 / timed.timing.median}};
  if (timed.row.bytes_per_pixel > 0) {
    row["bytes_per_pixel"] = timed.row.bytes_per_pixel;
    row["bandwidth_share"] = timed.bytes_per_second() / bandwidth;
  }
  return row;
}

void tell_table(const TimedRows& rows, const std::vector<int>& steps, Output& output) {
  std::vector<std::string> names;
  for (const TimedRow& timed : rows) {
    const bool listed = std::find(names.begin(), names.end(), timed.row.name) != names.end();
    if (!listed && !timed.row.name.starts_with("pcmp")) {
      names.push_back(timed.row.name);
    }
  }
  std::string heading = fmt::format("{:<18}", "640x480, one thread");
  for (const int N : steps) heading += fmt::format("{:>26}", fmt::format("N = {}", N));
  output.say("{}", heading);
  for (const std::string& name : names) {
    std::string line = fmt::format("{:<18}", name);
    for (const int N : steps) {
      const TimedRow* timed = find(rows, name, N);
      line += timed == nullptr
                  ? fmt::format("{:>26}", "")
                  : fmt::format("{:>9.3f} ms +-{:>3.0f}%{:>7.0f}/s", timed->timing.median,
                                50 * (timed->timing.upper_quartile - timed->timing.lower_quartile) /
                                    timed->timing.median,
                                1e3 / timed->timing.median);
    }
    output.say("{}", line);
  }
}

void tell_multiplexed(const TimedRows& rows, Output& output) {
  const TimedRow* three = find(rows, "fused", 3);
  output.say("\nphase channel multiplexing          ms      fps   of fused, N = 3");
  for (const TimedRow& timed : rows) {
    if (!timed.row.name.starts_with("pcmp")) continue;
    output.say("{:<18} {:>8} {:>10.3f} {:>8.0f} {:>10.2f}", timed.row.name, "", timed.timing.median,
               1e3 / timed.timing.median, timed.timing.median / three->timing.median);
  }
}

void tell_sizes(const TimedRows& rows, double bandwidth, Output& output) {
  output.say(
      "\nfused, N = 3        threads        ms      fps   ns/pixel   bytes/pixel   of bandwidth");
  for (const TimedRow& timed : rows) {
    const BenchRow& row = timed.row;
    if (row.name != "fused" || row.steps != 3) continue;
    const double pixels = static_cast<double>(row.width) * row.height;
    output.say("{:>5}x{:<4} {:>5.1f} MP {:>6} {:>11.3f} {:>8.0f} {:>10.3f} {:>13.1f} {:>13.0f}%",
               row.width, row.height, 1e-6 * pixels, row.threads, timed.timing.median,
               1e3 / timed.timing.median, 1e6 * timed.timing.median / pixels, row.bytes_per_pixel,
               100 * timed.bytes_per_second() / bandwidth);
  }
}

/// How many times as fast the fused pass is, and what else it is held against.
nlohmann::json ratios_of(const TimedRows& rows) {
  nlohmann::json ratios = nlohmann::json::object();
  const TimedRow* fused = find(rows, "fused", 3);
  if (fused == nullptr) return ratios;
  for (const char* other : {"lut", "traditional", "simd", "opencv-psp", "opencv-hand"}) {
    if (const TimedRow* row = find(rows, other, 3)) {
      ratios[other] = row->timing.median / fused->timing.median;
    }
  }
  for (const char* other : {"fused-corrected", "fused-dual"}) {
    if (const TimedRow* row = find(rows, other, 3)) {
      ratios[other] = row->timing.median / fused->timing.median;
    }
  }
  for (const TimedRow& timed : rows) {
    if (timed.row.name.starts_with("pcmp")) {
      ratios[timed.row.name] = timed.timing.median / fused->timing.median;
    }
  }
  const TimedRow* largest = fused;
  for (const TimedRow& timed : rows) {
    if (timed.row.name == "fused" && timed.row.threads == 1 && timed.row.steps == 3 &&
        timed.row.width > largest->row.width) {
      largest = &timed;
    }
    if (timed.row.name == "fused" && timed.row.threads > 1 && timed.row.width == 640) {
      ratios["threads"] = fused->timing.median / timed.timing.median;
    }
  }
  const auto per_pixel = [](const TimedRow& timed) {
    return timed.timing.median / (static_cast<double>(timed.row.width) * timed.row.height);
  };
  if (largest != fused) ratios["largest_per_pixel"] = per_pixel(*largest) / per_pixel(*fused);
  return ratios;
}

void tell_ratios(const nlohmann::json& ratios, Output& output) {
  output.say("\nN = 3, 640x480, one thread, fused against");
  for (const char* other : {"lut", "traditional", "simd", "opencv-psp", "opencv-hand"}) {
    if (ratios.contains(other)) {
      output.say("  {:<12} {:.1f} times as fast", other, ratios[other].get<double>());
    }
  }
  const auto say = [&](const char* key, const char* words) {
    if (ratios.contains(key)) output.say("  {} {:.2f}", words, ratios[key].get<double>());
  };
  say("fused-corrected", "time with a phase correction, times the time without:");
  say("fused-dual", "time of two frequencies (6 frames), times that of one:");
  say("largest_per_pixel", "time per pixel of the largest picture, times that of 640x480:");
  say("threads", "time on one thread, times that on all:");
}

void bench(const BenchFlags& flags, int threads, Output& output) {
  BenchSettings settings;
  TimingSettings timing;
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  settings.most_threads = threads > 0 ? threads : cores;
  if (flags.quick) {
    settings.steps = {3};
    settings.enlargements = {1};
    timing = {.rounds = 1, .row_seconds = 0};
  }
  output.say("machine: {}, vectors: {}", processor_name(), vector_targets().front());
  const double bandwidth = streaming_bandwidth();
  output.say("streaming bandwidth of one thread: {:.1f} GB/s\n", 1e-9 * bandwidth);
  const std::vector<BenchRow> rows = bench_rows(settings);
  Progress progress("rows", timing.rounds * static_cast<int>(rows.size()));
  const std::vector<Timing> timings = timed(rows, timing, [&] { progress.advance(); });
  progress.finish();

  TimedRows table;
  for (std::size_t i = 0; i < rows.size(); ++i) table.push_back({rows[i], timings[i]});
  const nlohmann::json ratios = ratios_of(table);
  tell_table(table, settings.steps, output);
  tell_multiplexed(table, output);
  tell_sizes(table, bandwidth, output);
  tell_ratios(ratios, output);
  output.say("\npublished, frames to cloud, 640x480, N = 3:");
  output.document = {{"machine", processor_name()},        {"vectors", vector_targets().front()},
                     {"bandwidth_bytes_per_s", bandwidth}, {"ratios", ratios},
                     {"rows", nlohmann::json::array()},    {"published", nlohmann::json::array()}};
  for (const PublishedMark& mark : published_marks) {
    output.say("  {:>4}/s  {}", mark.fps, mark.source);
    output.document["published"].push_back({{"source", mark.source}, {"fps", mark.fps}});
  }
  for (const TimedRow& timed : table) {
    output.document["rows"].push_back(json_of(timed, bandwidth));
  }
}

}  // namespace

void add_bench(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command =
      program.add_subcommand("bench", "times of every stage on this machine, and of its peers");
  const auto flags = std::make_shared<BenchFlags>();
  command->add_flag("--quick", flags->quick, "N = 3 and 640x480 alone, one run of each row");
  add_shared_flags(*command, shared);
  command->footer(
      "Examples:\n  slipstream bench\n  slipstream bench --json > bench.json\nRatios within one "
      "run "
      "hold better than times from run to run: other work on the machine slows all rows.");
  command->callback([flags, &shared, &chosen] {
    chosen = [flags, &shared](Output& output) { bench(*flags, shared.threads, output); };
  });
}

}  // namespace slipstream::app
