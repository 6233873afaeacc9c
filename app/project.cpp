#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/commands.h"
#include "app/process.h"
#include "app/scan_flags.h"
#include "devices/dlp.h"
#include "devices/hid_port.h"
#include "devices/monitor.h"
#include "frames/colour_channels.h"
#include "io/file.h"
#include "view/opengl.h"

namespace slipstream::app {
namespace {

using Monitor = opengl::WindowSystem::Monitor;

struct ProjectFlags {
  bool list = false;
  int monitor = 0;
  SequenceChanges scan;
  std::optional<double> rate;
  std::optional<int> hold;
  std::optional<double> duration;
  std::string log;
  bool in_colour = false;
  bool dlp = false;
};

void list_monitors(const std::vector<Monitor>& monitors, Output& output) {
  output.document["monitors"] = nlohmann::json::array();
  int number = 0;
  for (const Monitor& monitor : monitors) {
    output.say("{}: {}, {} at {} Hz, its corner at {},{}", number, monitor.name,
               text_of(monitor.size), monitor.refresh_hz, monitor.left, monitor.top);
    output.add_to("monitors", "monitor", number++, "name", monitor.name, "width",
                  monitor.size.width, "height", monitor.size.height, "left", monitor.left, "top",
                  monitor.top, "refresh_hz", monitor.refresh_hz);
  }

  if (monitors.empty()) output.say("no monitor is connected");

  for (const auto& [controller, path] : dlp::list_controllers()) {
    output.say("--dlp: {} at {}", name_of(controller), path);
    output.add_to("controllers", "name", name_of(controller), "path", path);
  }
}

/// The pictures to show, of the monitor's size.
Sequence sequence_on(const ProjectFlags& flags, const Monitor& monitor) {
  Sequence sequence = default_sequence(monitor.size, flags.scan);
  throw_if(
      sequence.projector != monitor.size,
      "--projector {} differs from the size of monitor {}, {}; change the monitor's resolution",
      text_of(sequence.projector), flags.monitor, text_of(monitor.size));

  sequence = cycle_of(std::move(sequence));
  if (flags.in_colour) require_in_colour(sequence, "--colour");
  return sequence;
}

/// Returns the number of pictures.
std::size_t load_patterns(monitor::MonitorSink& sink, const Sequence& sequence, bool in_colour) {
  const PatternSet set = pattern_set(sequence);
  if (!in_colour) {
    sink.load(patterns_in_8_bits(set, sequence.projector));
    return static_cast<std::size_t>(set.count);
  }

  // Three patterns make a picture. Other cycles than multiples of three run three times.
  std::vector<Image<Colour>> pictures;
  const int end = set.count % 3 == 0 ? set.count : 3 * set.count;

  for (int n = 0; n < end; n += 3) {
    pictures.push_back(picture_in_colour(set, n, sequence.projector));
  }

  const std::size_t count = pictures.size();
  sink.load_in_colour(std::move(pictures));
  return count;
}

/// Shows one-bit patterns from the memory of a DLPC900.
void project_from_memory(const ProjectFlags& flags, const RunEnd& end, Output& output) {
  dlp::DlpSink sink(dlp::open_controller(), nullptr,
                    {.rate = flags.rate.value_or(120), .ends = [&] { return end.reached(); }});

  const Sequence sequence = cycle_of(default_sequence(*sink.size(), flags.scan));
  output.say("{}; loading takes up to two minutes for each 24", sink.description());
  sink.load(patterns_in_8_bits(pattern_set(sequence), sequence.projector));

  sink.loop();
  output.say("showing {} patterns; press Ctrl-C to stop", cycle_length(sequence));

  // Loading does not count towards --duration.
  const double begin = end.seconds(), most = flags.duration.value_or(HUGE_VAL);
  while (!end.reached() && end.seconds() - begin < most) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }

  sink.give_back();
}

void tell(const monitor::ProjectionReport& report, const monitor::MonitorSink& projector, int hold,
          Output& output) {
  // The rate is over the intervals between patterns, one fewer than the patterns.
  const double rate =
      report.seconds > 0 ? static_cast<double>(report.shown - 1) / report.seconds : 0;

  output.say("{} patterns in {:.1f} s, {:.2f} per second; {} late", report.shown, report.seconds,
             rate, report.late);

  if (!report.waits_for_refresh) {
    output.warn(
        "the driver does not wait for the monitor's refresh; patterns were timed by the clock "
        "instead");
  }

  if (!projector.state().empty()) output.warn(projector.state());
  output.document = described("patterns", report.shown, "late", report.late, "seconds",
                              report.seconds, "patterns_per_second", rate, "hold", hold,
                              "refresh_hz", projector.refresh_hz(), "waits_for_refresh",
                              report.waits_for_refresh, "gamma_table", projector.has_gamma_table());
}

void project_scan(const ProjectFlags& flags, Output& output) {
  require_duration(flags.duration);
  const RunEnd end(std::nullopt);

  // 1. Patterns of one bit run from the controller's memory, without a monitor.
  if (flags.dlp && flags.scan.binary && !flags.list) return project_from_memory(flags, end, output);

  // 2. Choose the monitor.
  const opengl::WindowSystem system;
  const std::vector<Monitor> monitors = system.monitors();
  if (flags.list) return list_monitors(monitors, output);

  const auto place = static_cast<std::size_t>(flags.monitor);  // negative numbers become large ones
  throw_if(place >= monitors.size(),
           "--monitor {} does not exist; {} connected, numbered from 0, see --list", flags.monitor,
           monitors.size());

  // 3. Each pattern is held for whole refreshes of the monitor.
  const Monitor& monitor = monitors[place];
  const int hold = monitor::refreshes_for(flags.rate, flags.hold, monitor.refresh_hz);

  throw_if(flags.dlp && hold != 1,
           "--dlp shows three patterns per refresh; drop --rate and --hold");

  // 4. Load the patterns, and open the LightCrafter's controller.
  const Sequence sequence = sequence_on(flags, monitor);
  monitor::MonitorSink projector(system, flags.monitor);
  const std::size_t count = load_patterns(projector, sequence, flags.in_colour || flags.dlp);

  std::optional<dlp::DlpSink> controlled;
  if (flags.dlp) {
    const dlp::DlpSettings refreshes{.rate = projector.refresh_hz()};
    controlled.emplace(dlp::open_controller(), &projector, refreshes);
    output.say("{}", controlled->description());
    controlled->show(0);
  }

  std::string log = "swap,pattern,seconds\n";
  output.say("showing {} patterns; press Ctrl-C or Esc to stop", count);
  const double begin = end.seconds(), most = flags.duration.value_or(HUGE_VAL);
  const monitor::ProjectionSettings settings{
      .refresh_hz = projector.refresh_hz(),
      .hold = hold,
      .on_swap =
          [&](const monitor::PatternSwap& swap) {
            if (flags.log.empty()) return;
            log += fmt::format("{},{},{:.6f}\n", swap.sequence, swap.pattern, swap.seconds);
          },
      .ends = [&] { return projector.closed() || end.reached() || end.seconds() - begin >= most; }};
  const monitor::ProjectionReport report = monitor::project_patterns(projector, count, settings);

  if (controlled) controlled->give_back();
  tell(report, projector, hold, output);

  if (!flags.log.empty()) {
    write_file(flags.log, log);
    output.add_file("log", flags.log);
  }
}

}  // namespace

void add_project(const Commands& program) {
  const auto [command, flags] = program.add(
      project_scan, "project", "show a strategy's patterns on a projector connected as a monitor");

  command.add("--list", flags.list, "list the monitors and exit");
  command.add("--monitor", flags.monitor, "monitor number, see --list");
  command.add("--rate", flags.rate,
              "patterns per second: the monitor's refresh rate divided by a whole number");
  command.add("--hold", flags.hold, "monitor refreshes per pattern")->default_str("1");
  command.add("--duration", flags.duration, "stop after this many seconds");

  command.add_output("--log", flags.log, "log of when each pattern was shown: .csv");
  add_pattern_flags(command.app, flags.scan, true);
  command.add("--colour", flags.in_colour,
              "show three patterns at once, in red, green and blue; they count as one");

  command.add(
      "--dlp", flags.dlp,
      "the monitor is a LightCrafter (DLPC350, DLPC900 on USB): show three grey patterns per "
      "refresh; with --binary a DLPC900 shows them from its memory, at --rate (120)");

  command.common({"--list", "--monitor", "--strategy", "--steps", "--high", "--low", "--rate",
                  "--colour", "--dlp", "--duration"});
  command.examples({"project --list", "project --monitor 1 --strategy pmp --steps 4 --rate 30",
                    "project --monitor 1 --colour --strategy de-bruijn"},
                   "Patterns are shown pixel for pixel, with the monitor's gamma table off. Press "
                   "Esc or Ctrl-C to stop.");
}

}  // namespace slipstream::app
