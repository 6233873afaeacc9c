#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/scan_flags.h"
#include "app/stop_signal.h"
#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/pattern/pattern_in_8_bits.h"
#include "slipstream/project/monitor_sink.h"
#include "slipstream/project/projection.h"

namespace slipstream::app {
namespace {

using Monitor = opengl::WindowSystem::Monitor;

struct ProjectFlags {
  bool list = false;
  int monitor = 0;
  ScanFlags scan;
  std::optional<double> rate;
  std::optional<int> hold;
  std::optional<double> duration;
  std::string log;
};

nlohmann::json json_of(const Monitor& monitor, int number) {
  return {{"monitor", number},
          {"name", monitor.name},
          {"width", monitor.size.width},
          {"height", monitor.size.height},
          {"left", monitor.left},
          {"top", monitor.top},
          {"refresh_hz", monitor.refresh_hz}};
}

void list_monitors(const std::vector<Monitor>& monitors, Output& output) {
  output.document["monitors"] = nlohmann::json::array();
  int number = 0;
  for (const Monitor& monitor : monitors) {
    output.say("{}: {}, {} at {} Hz, its corner at {},{}", number, monitor.name,
               text_of(monitor.size), monitor.refresh_hz, monitor.left, monitor.top);
    output.document["monitors"].push_back(json_of(monitor, number++));
  }
  if (monitors.empty()) output.say("no monitor is connected");
}

const Monitor& monitor_at(const std::vector<Monitor>& monitors, int number) {
  if (number < 0 || static_cast<std::size_t>(number) >= monitors.size()) {
    throw Error(fmt::format("--monitor {} is not there; {} connected, numbered from 0, see --list",
                            number, monitors.size()));
  }
  return monitors[static_cast<std::size_t>(number)];
}

int hold_from(const ProjectFlags& flags, const Monitor& monitor) {
  if (flags.rate && flags.hold) throw Error("--rate and --hold exclude each other");
  if (flags.hold && *flags.hold < 1) {
    throw Error(fmt::format("--hold {} is out of range; 1 or more refreshes", *flags.hold));
  }
  if (!flags.rate) return flags.hold.value_or(1);
  if (monitor.refresh_hz <= 0) {
    throw Error(fmt::format(
        "--rate {}: the monitor does not say how often it refreshes; use --hold", *flags.rate));
  }
  return project::refreshes_for_rate(*flags.rate, monitor.refresh_hz);
}

std::vector<Image<std::uint8_t>> patterns_from(const ProjectFlags& flags, const Monitor& monitor) {
  const Size projector = projector_from(flags.scan, monitor.size);
  if (projector != monitor.size) {
    throw Error(
        fmt::format("--projector {} is not the size of monitor {}, {}; set the monitor to it",
                    text_of(projector), flags.monitor, text_of(monitor.size)));
  }
  const Strategy strategy = strategy_from(flags.scan, DualFrequency{});
  const Axis axis = axis_from(flags.scan, Axis::x);
  require_resolved(strategy, length_along(axis, projector));
  const PatternSet set = pattern_set(strategy, axis, light_from(flags.scan, {}));
  std::vector<Image<std::uint8_t>> patterns;
  for (int n = 0; n < set.count; ++n) {
    patterns.push_back(in_8_bits(render_pattern(set, n, projector)));
  }
  return patterns;
}

/// The log's line of a swap: its number, its pattern, and when, s from the first.
std::string line_of(const project::PatternSwap& swap, const project::PatternSwap& first) {
  return fmt::format("{},{},{:.6f}\n", swap.sequence, swap.pattern,
                     std::chrono::duration<double>(swap.time - first.time).count());
}

void tell(const project::ProjectionReport& report, const project::MonitorSink& projector, int hold,
          Output& output) {
  const double rate =
      report.seconds > 0 ? static_cast<double>(report.shown - 1) / report.seconds : 0;
  output.say("{} patterns in {:.1f} s, {:.2f} per second; {} late", report.shown, report.seconds,
             rate, report.late);
  if (!report.waits_for_refresh) {
    output.warn("the driver does not wait for the monitor's refresh; patterns went by the clock");
  }
  if (!projector.state().empty()) output.warn(projector.state());
  output.document = {{"patterns", report.shown},
                     {"late", report.late},
                     {"seconds", report.seconds},
                     {"patterns_per_second", rate},
                     {"hold", hold},
                     {"refresh_hz", projector.refresh_hz()},
                     {"waits_for_refresh", report.waits_for_refresh},
                     {"gamma_table", projector.has_gamma_table()}};
}

void project_scan(const ProjectFlags& flags, Output& output) {
  if (flags.duration && !(*flags.duration > 0)) {
    throw Error(fmt::format("--duration {} is out of range; above 0 s", *flags.duration));
  }
  const opengl::WindowSystem system;
  const std::vector<Monitor> monitors = system.monitors();
  if (flags.list) {
    list_monitors(monitors, output);
    return;
  }
  const Monitor& monitor = monitor_at(monitors, flags.monitor);
  const int hold = hold_from(flags, monitor);
  auto patterns = patterns_from(flags, monitor);
  const std::size_t count = patterns.size();
  project::MonitorSink projector(system, flags.monitor);
  projector.load(std::move(patterns));

  std::string log = "swap,pattern,seconds\n";
  std::optional<project::PatternSwap> first;
  project::ProjectionSettings settings{.refresh_hz = projector.refresh_hz(), .hold = hold};
  settings.on_swap = [&](const project::PatternSwap& swap) {
    if (!first) first = swap;
    if (!flags.log.empty()) log += line_of(swap, *first);
  };
  const StopSignal stop;
  const auto start = std::chrono::steady_clock::now();
  settings.ends = [&] {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    return projector.closed() || stop.raised() ||
           (flags.duration && passed.count() >= *flags.duration);
  };
  const project::ProjectionReport report = project::project_patterns(projector, count, settings);
  tell(report, projector, hold, output);
  if (!flags.log.empty()) {
    write_file(flags.log, log);
    output.say("log: {}", flags.log);
    output.document["files"] = {{"log", flags.log}};
  }
}

}  // namespace

void add_project(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command = program.add_subcommand(
      "project", "show a strategy's patterns on a projector that is a monitor");
  const auto flags = std::make_shared<ProjectFlags>();
  command->add_flag("--list", flags->list, "say which monitors there are, and end");
  command->add_option("--monitor", flags->monitor, "its number in --list")->capture_default_str();
  command->add_option("--rate", flags->rate,
                      "patterns per second: the monitor's refreshes divided by a whole number");
  command->add_option("--hold", flags->hold,
                      "refreshes that each pattern stays for; 1 if not given");
  command->add_option("--duration", flags->duration, "seconds, then it ends");
  command->add_option("--log", flags->log, "which pattern was shown when: .csv");
  add_scan_flags(*command, flags->scan);
  add_shared_flags(*command, shared);
  command->footer(
      "Examples:\n  slipstream project --list\n  slipstream project --monitor 1 --strategy pmp "
      "--steps 4 --rate 30\nEvery pixel of the monitor shows its own grey level, with the "
      "monitor's "
      "gamma table off. Esc or Ctrl-C ends it.");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { project_scan(*flags, output); }; });
}

}  // namespace slipstream::app
