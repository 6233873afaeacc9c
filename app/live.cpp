#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/commands.h"
#include "app/frame_sources.h"
#include "app/gamma_choice.h"
#include "app/live_session.h"
#include "app/scan_input.h"
#include "app/stop_signal.h"
#include "slipstream/error/error.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/photometric_file.h"
#include "slipstream/io/response_file.h"
#include "slipstream/io/scanner_file.h"

namespace slipstream::app {
namespace {
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

struct LiveFlags {
  SourceRequest source;
  std::optional<double> duration;
  std::optional<std::uint64_t> frames;
  bool headless = false;
  std::string indexing = "told";
  std::string gamma = "scanner";
  bool keep_saturated = false;
  ReconstructSettings settings;
  std::string output;
  std::string record;
  ViewFlags view;
};

void require_scanner(const OpenedSource& opened, const LiveFlags& flags) {
  if (opened.scanner.empty()) {
    throw Error(fmt::format("{}: no scanner is known for it; name its file with --scanner",
                            flags.source.source));
  }
}

GammaChoice gamma_of(const OpenedSource& opened, const LiveFlags& flags) {
  return choose_gamma(flags.gamma, response_from(opened.scanner, opened.scanner_name),
                      step_counts(opened.scan.strategy));
}

LiveScan scan_of(const OpenedSource& opened, const LiveFlags& flags, const GammaChoice& gamma) {
  const std::string& file = opened.scanner_name;
  const PhotometricCalibration known = photometric_calibration_from(opened.scanner, file);
  require_known_light(opened.scan.strategy, known, file);
  ReconstructSettings settings = flags.settings;
  settings.backend = Backend::fused;
  settings.drop_saturated = !flags.keep_saturated;
  return {.scanner = completed(scanner_from(opened.scanner, file), file,
                               opened.frames->format().size, opened.scan.projector),
          .strategy = opened.scan.strategy,
          .axis = opened.scan.axis,
          .settings = settings_for(settings, opened.scan, gamma, known)};
}

nlohmann::json json_of(const Latency& latency) {
  return {{"p50", latency.p50}, {"p99", latency.p99}, {"max", latency.max}};
}

nlohmann::json json_of(const LiveStatistics& statistics) {
  nlohmann::json stages = nlohmann::json::array();
  for (const StageStatistics& stage : statistics.stages) {
    stages.push_back({{"name", stage.name},
                      {"done", stage.done},
                      {"rate", stage.rate},
                      {"waiting", stage.waiting},
                      {"capacity", stage.capacity},
                      {"latency_ms", json_of(stage.latency)}});
  }
  const LiveStatistics::Frames& frames = statistics.frames;
  return {{"frames",
           {{"captured", frames.captured},
            {"lost", frames.lost},
            {"overwritten", frames.overwritten},
            {"repeated", frames.repeated}}},
          {"clouds", statistics.clouds},
          {"clouds_per_second", statistics.clouds_per_second},
          {"windows_lost", statistics.windows_lost},
          {"resynchronisations", statistics.resynchronisations},
          {"seconds", statistics.seconds},
          {"latency_ms", json_of(statistics.latency)},
          {"screen_latency_ms", json_of(statistics.screen_latency)},
          {"stages", std::move(stages)}};
}

void tell(const LiveStatistics& statistics, Output& output) {
  const LiveStatistics::Frames& frames = statistics.frames;
  output.say("{} frames in {:.1f} s: {} lost, {} overwritten, {} repeated", frames.captured,
             statistics.seconds, frames.lost, frames.overwritten, frames.repeated);
  output.say("{} clouds, {:.1f} per second; {} windows without one, {} resynchronisations",
             statistics.clouds, statistics.clouds_per_second, statistics.windows_lost,
             statistics.resynchronisations);
  output.say(
      "capture to cloud: {:.2f} ms half of the time, {:.2f} ms for 99 of 100, {:.2f} at most",
      statistics.latency.p50, statistics.latency.p99, statistics.latency.max);
}

/// Tells whatever a source has to say, once.
class StateTeller {
 public:
  void operator()(const std::string& state, Output& output) {
    if (state == told_) return;
    if (state.empty()) {
      output.say("the source is well again");
    } else {
      output.warn(state);
    }
    told_ = state;
  }

 private:
  std::string told_;
};

void wait_until_over(LiveSession& session, Output& output) {
  StateTeller tell_state;
  while (!session.is_over()) {
    std::this_thread::sleep_for(20ms);
    tell_state(session.recorder.state(), output);
  }
}

void require_good(const LiveFlags& flags) {
  if (flags.duration && !(*flags.duration > 0)) {
    throw Error(fmt::format("--duration {} is out of range; above 0 s", *flags.duration));
  }
  if (flags.frames == 0U) throw Error("--frames 0 is out of range; 1 or more");
  if (!flags.output.empty()) require_cloud_ending(flags.output);
#ifdef SLIPSTREAM_VIEW
  require_good(flags.view);
#else
  if (!flags.headless) throw Error("this build has no viewer; add --headless");
#endif
}

/// Runs the session to its end; what a stage threw comes out here.
void run_session(LiveSession& session, [[maybe_unused]] bool headless, Output& output) {
#ifdef SLIPSTREAM_VIEW
  if (!headless) {
    show_in_window(session, output);
    return;
  }
#endif
  wait_until_over(session, output);
}

/// What the session measured, and what is to be kept of its last cloud.
void write_results(LiveSession& session, const LiveFlags& flags, Output& output) {
  const LiveStatistics statistics = session.pipeline.statistics();
  tell(statistics, output);
  output.document.update(json_of(statistics));
  output.document["source"] = flags.source.source;
  if (const auto failure = session.pipeline.failure()) std::rethrow_exception(failure);
  if (!flags.output.empty()) {
    const Pooled<LiveCloud> last = session.pipeline.newest();
    if (!last)
      throw WorldError(fmt::format("{}: no cloud came that could be written", flags.output));
    write_cloud(flags.output, cloud_of(last->cloud));
    output.document["files"]["cloud"] = flags.output;
  }
#ifdef SLIPSTREAM_VIEW
  draw_newest(session, flags.headless, output);
#endif
}

void live(LiveFlags flags, Output& output) {
  require_good(flags);
  flags.source.indexing = pattern_indexing_named(flags.indexing);
  OpenedSource opened = open_source(flags.source);
  if (!opened.warning.empty()) output.warn(opened.warning);
  require_scanner(opened, flags);
  const GammaChoice gamma = gamma_of(opened, flags);
  const LiveScan scan = scan_of(opened, flags, gamma);
  if (!gamma.sentence.empty()) output.say("{}", gamma.sentence);

  const RecordingHeader header{.format = opened.frames->format(),
                               .frame_rate = flags.source.rate.value_or(0),
                               .scan = opened.scan,
                               .scanner = opened.scanner};
  auto source = std::make_unique<RecordedSource>(std::move(opened.frames), header);
  RecordedSource& recorder = *source;
  LivePipeline pipeline(std::move(source), scan,
                        {.indexing = flags.source.indexing, .most_frames = flags.frames});

  const StopSignal stop;
  if (!flags.record.empty()) {
    require_not_replayed(flags.source, flags.record);
    recorder.record_to(flags.record);
  }
  const auto start = Clock::now();
  const auto time_over = [&] {
    const std::chrono::duration<double> passed = Clock::now() - start;
    return flags.duration && passed.count() >= *flags.duration;
  };
  pipeline.start();
  const std::string scheme = flags.source.source.substr(0, flags.source.source.find(':'));
  LiveSession session{pipeline,
                      recorder,
                      scan,
                      [&] {
                        const bool at_end = flags.headless || flags.frames;
                        return stop.raised() || time_over() || pipeline.failure() ||
                               (at_end && !pipeline.running());
                      },
                      flags.source.source,
                      scheme != "virtual" && scheme != "replay",
                      flags.view,
                      {.text = opened.scanner, .name = opened.scanner_name, .gammas = {gamma}}};
  output.document["files"] = nlohmann::json::object();
  run_session(session, flags.headless, output);
  pipeline.stop();

  write_results(session, flags, output);
  recorder.finish_recording();  // one that was begun in the window too
  if (!flags.record.empty()) output.document["files"]["recording"] = flags.record;
}

}  // namespace

void add_live(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command = program.add_subcommand(
      "live", "cameras, virtual scanner or recording to clouds, as frames come");
  const auto flags = std::make_shared<LiveFlags>();
  flags->source.virtual_scanner.motion = {0.5, 0, 0};
  command->add_option("--source", flags->source.source, source_forms())->capture_default_str();
  command->add_option("--rate", flags->source.rate,
                      "frames per second; 0: as fast as it goes; else the source's own");
  command->add_flag("--loop", flags->source.loop, "a recording begins again at its end");
  command->add_option("--duration", flags->duration, "seconds, then it ends");
  command->add_option("--frames", flags->frames, "so many frames, then it ends");
  command->add_flag("--headless", flags->headless, "no window");
  command->add_option("-o,--output", flags->output, "the last cloud: .ply, .pcd or .xyz");
  command->add_option("--record", flags->record, "all frames, for replay:PATH");
  command
      ->add_option("--indexing", flags->indexing,
                   "how it is known which pattern a frame shows: told (by the source), counted "
                   "(frames modulo patterns) or marker (a dark or bright frame ends each cycle)")
      ->capture_default_str();
  command->add_option("--scanner", flags->source.scanner,
                      "scanner file; where not that of the recording or of the virtual scanner");
  command
      ->add_option("--gamma", flags->gamma,
                   "the response the phase is corrected for: scanner (as its file says, if it "
                   "does), none, or a number")
      ->capture_default_str();
  const std::string points = "Which pixels become points";
  command
      ->add_option("--min-modulation", flags->settings.minimum_modulation,
                   "least modulation, grey levels of the frames; 15 of 255 where not given")
      ->group(points);
  command->add_flag("--keep-saturated", flags->keep_saturated, "keep pixels with a saturated frame")
      ->group(points);
  command->add_option("--nearest", flags->settings.nearest, "least depth, mm")
      ->capture_default_str()
      ->group(points);
  command->add_option("--farthest", flags->settings.farthest, "largest depth, mm")->group(points);
#ifdef SLIPSTREAM_VIEW
  add_view_flags(*command, flags->view);
#endif
  add_scan_flags(*command, flags->source.scan);
  add_virtual_flags(*command, flags->source.virtual_scanner, "--virtual-gamma");
  add_camera_flags(*command, flags->source.camera);
  add_shared_flags(*command, shared);
  command->footer(
      "Examples:\n  slipstream live --source virtual --rate 120 --strategy pmp --steps 4\n  "
      "slipstream live --source replay:scan.slip --headless --json\n  slipstream live --source "
      "virtual --frames 100 --headless -o cloud.ply");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { live(*flags, output); }; });
}

}  // namespace slipstream::app
