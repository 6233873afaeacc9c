#include "app/calibrate_repeat.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/process.h"
#include "app/report_facts.h"
#include "calibrate/depth_drift.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/plot.h"
#include "slipstream/scan_job.h"
#include "slipstream/strategy.h"

namespace slipstream::app {
namespace {

/// A scene that does not move, and the rig that scans it.
class FixedScene {
 public:
  FixedScene(const CaptureFlags& flags, Output& output)
      : flags_(flags), output_(output), rig_(open_rig(flags_, output)) {}

  /// The depths of a new scan, mm. Throws as still_frames and ScanJob.
  Image<float> depth() {
    // The virtual camera repeats its frames, so each scan has one of its own, with other noise.
    const bool is_virtual = scheme_of(flags_.source.source) == "virtual";
    if (is_virtual && std::exchange(scanned_, true)) {
      ++flags_.source.virtual_scanner.seed;
      CaptureRig opened = open_rig(flags_, output_);  // if that fails, the old one stays
      rig_.reset();
      rig_.emplace(std::move(opened));
    }

    const NamedSource& opened = rig_->opened;
    Scan scan{.frames = std::move(still_frames(*rig_, output_).front()),
              .sequence = opened.sequence,
              .scanner = opened.scanner};
    scan.sequence.marker = false;
    scan.scanner =
        completed(*scan.scanner, opened.scanner_name, scan.frames.size(), scan.sequence.projector);
    result_ = job_(merged(std::move(scan)), flags_.source.source);
    return result_.cloud.z;
  }

  /// Takes frames, so that none waits in the camera until it is old.
  void watch() { rig_->camera->look(std::chrono::milliseconds(100)); }

  [[nodiscard]] bool closed() const { return rig_->projector.closed(); }
  [[nodiscard]] Temperatures temperatures() const { return temperatures_of(*rig_->opened.frames); }
  /// Result of the last scan.
  [[nodiscard]] const ScanResult& result() const { return result_; }

 private:
  CaptureFlags flags_;
  Output& output_;
  std::optional<CaptureRig> rig_;
  bool scanned_ = false;
  ScanJob job_;
  ScanResult result_{};
};

/// The figures of all scans, over minutes since the first.
struct DepthSeries {
  PlotLine mean{"mean"}, uneven{"uneven"};   ///< see DepthChange; since the first scan
  std::vector<Temperatures> temperatures{};  ///< of each scan
  std::size_t failed = 0;                    ///< scans

  [[nodiscard]] std::size_t scans() const { return mean.x.size(); }
};

struct DriftVerdict {
  std::optional<Steadiness> depth{};  ///< `since` when it is even too
  Verdict answer{};
};

DriftVerdict judged(const DepthSeries& series) {
  const std::string all =
      fmt::format("{} in {:.2f} min", counted(series.scans(), "scan"), series.mean.x.back());
  if (series.scans() < least_values_to_judge) {
    return {.answer = {"usable", fmt::format("too few scans to tell whether depth is steady: {}; "
                                             "at least {}",
                                             all, least_values_to_judge)}};
  }

  // Depth is steady if its mean and its unevenness are.
  Steadiness depth = steadiness(series.mean.x, series.mean.y);
  const Steadiness uneven = steadiness(series.uneven.x, series.uneven.y);

  std::vector<std::string> unsteady;
  for (const auto& [name, figure] :
       {std::pair("mean change", depth), std::pair("unevenness", uneven)}) {
    if (figure.since) continue;
    unsteady.push_back(fmt::format("its {} of {:.4f} mm still varies by more than {:.4f} mm", name,
                                   figure.level, figure.band));
  }

  if (!unsteady.empty()) {
    depth.since.reset();
    return {depth,
            {"bad", fmt::format("depth is not steady yet: {}; repeat for longer ({})",
                                fmt::join(unsteady, ", and "), all)}};
  }
  depth.since = std::max(depth.since, uneven.since);
  const std::string when =
      *depth.since > 0 ? fmt::format("after {:.2f} min", *depth.since) : "from the start";
  return {depth,
          {"good", fmt::format("depth is steady {}, within {:.4f} mm; it changed by "
                               "{:.4f} mm in all ({})",
                               when, depth.band, depth.level, all)}};
}

DepthSeries scanned_for(double minutes, FixedScene& scene, const RunEnd& end, Output& output) {
  constexpr int most_scans = 120;
  const double interval = 60 * minutes / most_scans;
  const auto goes_on = [&] { return !end.reached() && !scene.closed(); };

  DepthSeries series;
  std::optional<Image<float>> first;
  double start = 0;
  Progress progress("fixed scene", std::max(1.0, 60 * minutes));

  do {
    const double now = end.seconds();
    try {
      // 1. A scan, and its change since the first one.
      Image<float> depth = scene.depth();
      if (!first) {
        first = depth;
        start = now;
        output.warn(scene.result().checked.findings);
        output.say("scanning the fixed scene for {:g} min; Ctrl-C ends earlier", minutes);
      }
      const DepthChange change = depth_change(*first, depth);

      // 2. Its figures.
      const double at = (now - start) / 60;
      series.temperatures.push_back(scene.temperatures());
      series.mean.add(at, change.mean);
      series.uneven.add(at, change.uneven);
    } catch (const std::runtime_error& error) {
      if (series.scans() == 0) throw;
      if (goes_on() && series.failed++ == 0) output.warn(error.what());
    }

    // 3. Until the next one is due; that one tells if the camera has failed.
    progress.reach(static_cast<std::int64_t>(end.seconds()));
    while (goes_on() && end.seconds() < now + interval) {
      try {
        scene.watch();
      } catch (const std::runtime_error&) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
    }
  } while (goes_on());

  return series;
}

/// The temperature of each part of the camera over minutes.
std::map<std::string, PlotLine> temperature_lines(const DepthSeries& series) {
  std::map<std::string, PlotLine> lines;
  for (std::size_t i = 0; i < series.scans(); ++i) {
    for (const auto& [part, celsius] : series.temperatures[i]) {
      lines.try_emplace(part, PlotLine{part}).first->second.add(series.mean.x[i], celsius);
    }
  }
  return lines;
}

void write_report(const RepeatFlags& flags, const DepthSeries& series, const DriftVerdict& found,
                  const ScanResult& last, Output& output) {
  const fs::path folder = *flags.report;
  const SourceFlags& source = flags.capture.source;

  Page page("Depth of a fixed scene over time", &with_flags);
  page.verdict(found.answer);

  // 1. The plots.
  write_plot(folder / "depth.png", LinePlot{.title = "Change of depth since the first scan",
                                            .x_label = "minutes",
                                            .y_label = "mm",
                                            .lines = {series.mean, series.uneven}});
  page.picture(
      "Change of depth since the first scan: its mean over the picture, and the RMS about it of "
      "the means of 4x4 parts",
      "depth.png");

  const std::map<std::string, PlotLine> temperatures = temperature_lines(series);
  if (!temperatures.empty()) {
    LinePlot plot{.title = "Temperature of the camera",
                  .x_label = "minutes",
                  .y_label = "degrees Celsius",
                  .lines = {}};
    for (const auto& [part, line] : temperatures) plot.lines.push_back(line);
    write_plot(folder / "temperature.png", plot);
    page.picture("Temperature of the camera", "temperature.png");
  }

  // 2. The facts.
  Facts facts = facts_of_run(output);
  facts.emplace_back("source", source.source);
  add_scanner(facts, last.setup.scanner, *source.scanner);
  facts.emplace_back("patterns", label_of(last.setup.sequence.strategy));
  facts.emplace_back("scans", fmt::format("{}; {} failed", series.scans(), series.failed));
  if (found.depth) {
    facts.emplace_back("noise of a scan's mean", fmt::format("{:.4f} mm", found.depth->noise));
  }
  for (const auto& [part, line] : temperatures) {
    add_temperature(facts, part, line.y.front(), line.y.back());
  }
  page.facts(facts);

  write_page(folder / "report.html", page);
  output.document["report"] = *flags.report;
  output.say("the report is {}/report.html", *flags.report);
}

}  // namespace

void verify_over_time(const RepeatFlags& flags, Output& output) {
  constexpr double week = 7 * 24 * 60;
  const std::string& source = flags.capture.source.source;
  require_in_range(*flags.minutes > 0 && *flags.minutes <= week, "--repeat", *flags.minutes,
                   "above 0, at most 10080 minutes");
  throw_if(scheme_of(source) == "replay",
           "--repeat: {} shows the same scene again; use a camera, or virtual", source);

  FixedScene scene(flags.capture, output);
  if (flags.report) {
    // A report that cannot be written should not wait for the scans.
    make_folder(*flags.report);
    const OutputFile tried(fs::path(*flags.report) / "report.html");
  }

  const RunEnd end(60 * *flags.minutes);
  const DepthSeries series = scanned_for(*flags.minutes, scene, end, output);
  const DriftVerdict found = judged(series);

  for (std::size_t i = 0; i < series.scans(); ++i) {
    output.add_to("scans", "minutes", series.mean.x[i], "depth_change_mm", series.mean.y[i],
                  "uneven_mm", series.uneven.y[i], "temperatures_celsius", series.temperatures[i]);
  }
  output.add("failed_scans", series.failed);
  if (found.depth) {
    output.add("depth_change_mm", found.depth->level, "band_mm", found.depth->band, "noise_mm",
               found.depth->noise);
    output.document["steady_after_minutes"] = as_json(found.depth->since);
  }

  output.tell_verdict(found.answer.grade, found.answer.words);
  if (flags.report) write_report(flags, series, found, scene.result(), output);
}

void add_repeat_flags(const FlagGroup& command, RepeatFlags& flags) {
  SourceFlags& source = flags.capture.source;
  flags.capture.no_guard = true;

  CLI::Option* const repeat =
      command.add("--repeat", flags.minutes,
                  "instead of boards: scan a fixed scene for this many minutes, and tell since "
                  "when its depth is steady");
  const std::vector<CLI::Option*> others = command.app.get_options();

  // 1. The flags of the scans.
  repeat->needs(command.add("--source", source.source, source_forms()));
  add_monitor_flags(command, flags.capture);
  command.app.get_option("--settle")->needs("--monitor");
  command.add("--marker", source.sequence.marker,
              "each cycle ends with a dark frame, as by `project --marker`");
  command.add_output("--report", flags.report, "folder for a report with a plot of depth over time",
                     output_folder_type);
  add_camera_flags(command.app, source.camera);
  add_virtual_flags(command.app, source.virtual_scanner);

  // 2. They do not concern boards.
  for (CLI::Option* const option : command.app.get_options()) {
    if (std::ranges::find(others, option) == others.end()) option->needs(repeat);
  }
}

}  // namespace slipstream::app
