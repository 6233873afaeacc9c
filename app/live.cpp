#include "app/live.h"

#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "app/live_session.h"
#include "app/process.h"
#include "base/printable.h"
#include "frames/pattern_windows.h"
#include "io/model_file.h"

#ifdef SLIPSTREAM_VIEW
#include "view/opengl.h"
#endif

namespace slipstream::app {
namespace {

/// Prints each message about a session once; LiveSession::tell_news prints those of its sinks.
class SessionNews {
 public:
  SessionNews(const LiveSession& session, Output& output) : session_(session), output_(output) {}

  /// Diagnostics of the clouds, and why their backend is not the fastest.
  void tell_of_clouds() {
    tell_news(session_.pipeline().findings(), findings_, output_);
    if (fallback_) return;
    fallback_ = tell_fallback(session_.pipeline().statistics().fallback_reason, true, output_);
  }

  /// That the source fails, and that it has recovered.
  void tell_of_source() {
    const std::string state = session_.source().state();
    if (std::exchange(state_, state) == state) return;

    tell_service_manager("STATUS=" + printable(state));
    if (state.empty()) {
      output_.say("the source has recovered");
    } else {
      output_.warn(state);
    }
  }

  /// That a recording has reached its limit.
  void tell_of_limit() {
    const auto recording = session_.source().recording();
    if (!recording || std::exchange(limited_, recording->limited) == recording->limited) return;
    if (!limited_.empty()) output_.say("{}", limited_);
  }

 private:
  const LiveSession& session_;
  Output& output_;

  // As printed so far:
  std::vector<LiveFinding> findings_;
  bool fallback_ = false;
  std::string state_, limited_;
};

/// Pixel statistics of the newest scan, when no scanner is known.
void tell_pictures(const LiveSession& session, Output& output) {
  const Pooled<LiveCloud> last = session.pipeline().newest();
  if (!last) return;

  const FrameViews frames = views_of(last->frames);
  const EngineSetup setup = session.setup();
  Maps maps;
  Engine engine(setup);
  engine.maps(frames, maps);
  const PictureReport report = picture_report(engine.merged(frames), maps, setup.settings);

  const auto counts = count_by_validity(report.validity);
  nlohmann::json& pixels = output.object("pixels");
  const auto share_of = [&](const char* name, Validity kind) {
    const auto count = counts[static_cast<std::size_t>(kind)];
    pixels[name] = count;
    return 100 * static_cast<double>(count) / static_cast<double>(report.validity.pixel_count());
  };

  const double measured = share_of("measured", Validity::valid),
               too_dark = share_of("too_dark", Validity::too_dark),
               saturated = share_of("saturated", Validity::saturated);

  pixels["median_modulation"] = report.modulation;
  output.say(
      "pixels: {:.1f} % measured, {:.1f} % too dark, {:.1f} % saturated; median modulation "
      "{:.1f} grey levels of 255",
      measured, too_dark, saturated, report.modulation);
}

/// The error of a run whose results need a cloud, and that had none.
WorldError no_cloud(const std::string& file, std::string_view problem, const LiveSession& session,
                    const LiveStatistics& statistics) {
  const auto needed = static_cast<std::uint64_t>(frame_count(session.setup().sequence));
  if (statistics.frames.captured >= needed) return WorldError(fmt::format("{}: {}", file, problem));

  return WorldError(fmt::format("{}: {}; a cloud takes {} frames, and {} came", file, problem,
                                needed, statistics.frames.captured));
}

/// Prints the session's statistics and writes its last cloud as requested.
void write_results(LiveSession& session, const LiveFlags& flags, Output& output) {
  const LiveStatistics statistics = session.pipeline().statistics();

  output.say_lines(text_of(statistics));
  for (const SinkStatistics& sink : session.sinks()) {
    output.say("{}: published {} of {} clouds{}", sink.name, sink.published,
               sink.published + sink.dropped,
               sink.dropped == 0 ? "" : "; the rest were dropped because its queue was full");
  }
  output.document.update(session.document());

  if (const auto failure = session.pipeline().failure()) std::rethrow_exception(failure);
  if (!has_geometry(session.setup().scanner)) tell_pictures(session, output);

  // The last cloud, the model of all clouds, and the pictures.
  const std::shared_ptr<const FramePose> frame = wanted_frame(flags.settings);
  if (!flags.output.empty()) {
    const Pooled<LiveCloud> last = session.pipeline().newest();
    if (!last || (flags.live.fuse && !last->fused)) {
      throw no_cloud(flags.output, "no cloud to write", session, statistics);
    }
    const std::string file = session.file_to_write(flags.output);
    const std::vector<std::string> remarks = remarks_about(statistics.findings);
    if (last->fused) {
      FusedModel model = *last->fused;
      if (frame) move_to_frame(model, *frame);
      write_model(file, model, remarks);
    } else {
      write_cloud(file, last->cloud, {.remarks = remarks, .frame = frame});
    }
    output.add_file("cloud", file);
  }

  if (!flags.model.empty()) {
    const ModelPoints model = session.pipeline().model();
    if (model.cloud.z.empty()) {
      throw no_cloud(flags.model, "no cloud to build a model from", session, statistics);
    }
    const std::string file = session.file_to_write(flags.model);
    write_cloud(file, model.cloud, {.normals = &model.normals, .frame = frame});
    output.say("model: {} points in {}", model.cloud.size().width, file);
    output.object("files")["model"] = file;
  }
#ifdef SLIPSTREAM_VIEW
  ViewFlags pictures = flags.view;
  for (std::string* const name : {&pictures.snapshot, &pictures.screenshot}) {
    if (!name->empty()) *name = session.file_to_write(*name);
  }
  const bool has_no_window = flags.headless || opengl::desktop_is_gone();
  write_pictures(session.view_source(), pictures, has_no_window, output);
#endif
}

/// Stops the session, prints what happened last, and writes the results.
void finish(LiveSession& session, SessionNews& news, const LiveFlags& flags, Output& output) {
  session.stop();
  session.tell_news();
  news.tell_of_clouds();

  std::exception_ptr unfinished;
  try {
    // Before anything that may end the program; a recording may have started in the window.
    session.finish_recording();
  } catch (const WorldError&) {
    unfinished = std::current_exception();
  }

  write_results(session, flags, output);
  if (unfinished) std::rethrow_exception(unfinished);

  for (const SinkStatistics& sink : session.sinks()) {
    if (!sink.error.empty()) throw WorldError(fmt::format("{}: {}", sink.name, sink.error));
  }
}

/// One reading of the rig file.
struct ServedRig {
  AppliedRig rig;  ///< tells the line that an error comes from
  LiveFlags flags;
};

/// Throws Error if the flags cannot be served.
ServedRig served(const Command& read) {
  LiveFlags flags = *read.served;
  flags.headless = true;
  flags.new_files = true;
  flags.command = nullptr;  // these flags may outlive it

  locating(read.rig, [&] {
    throw_if(flags.publish.empty() && flags.record.empty(),
             "the rig file has neither publish nor record, so clouds would go nowhere; add e.g. "
             "publish: [web:8080]");
    require_good(flags);
  });

  return {read.rig, flags};
}

/// Waits for that time, or until SIGHUP asks for a reload or a signal for the end. Returns whether
/// SIGHUP has come.
bool reload_is_wanted_within(std::chrono::milliseconds time) {
  for (constexpr std::chrono::milliseconds step(20); time.count() > 0; time -= step) {
    if (take_reload_request()) return true;
    if (stopped_by_signal()) break;
    std::this_thread::sleep_for(step);
  }
  return false;
}

/// How far a service is with a reload.
enum class Reload {
  done,          ///< the run has begun
  new_settings,  ///< are tried
  old_settings,  ///< are tried again, as the new ones failed
  waiting,       ///< the old ones failed too, as while the camera is away; tried every second
};

void serve(const LiveFlags& given, Output& output) {
  const ReadAgain read_again = given.command->read_again;
  ServedRig now = served(*given.command);

  // Remembers a signal between two runs too.
  const RunEnd end(std::nullopt);

  // A service keeps running with what worked before.
  const auto refuse = [&](const std::exception& error, const char* then) {
    output.warn(fmt::format("{}; {}", error.what(), then));
  };

  Reload reload = Reload::done;
  std::optional<ServedRig> before;  // the old settings, while new ones are tried
  while (true) {
    // Called by the run: once it works, and when SIGHUP asks for a reload.
    std::optional<ServedRig> next;
    now.flags.begun = [&] { reload = Reload::done; };

    now.flags.reload = [&] {
      try {
        next = served(*read_again());
        output.say("restarting");
      } catch (const std::exception& error) {
        refuse(error, "continuing with the old settings");
      }
      return next.has_value();
    };

    // Run until a signal ends it, or until a reload has brought new settings.
    try {
      locating(now.rig, [&] { live(now.flags, output); });
      if (!next || stopped_by_signal()) return;
    } catch (const std::exception& error) {
      if (reload == Reload::done && (!next || stopped_by_signal())) throw;
      if (stopped_by_signal()) return;

      // The run ended for new settings, but could not complete its files.
      if (next) {
        output.warn(error.what());
      } else if (reload == Reload::new_settings) {  // only known once all is opened
        refuse(error, "continuing with the old settings");
        now = *std::exchange(before, std::nullopt);
        reload = Reload::old_settings;
        continue;
      } else {
        if (reload == Reload::old_settings) refuse(error, "trying again");
        reload = Reload::waiting;
        if (reload_is_wanted_within(std::chrono::seconds(1))) now.flags.reload();
        if (!next) continue;
      }
    }

    before = std::exchange(now, *next);
    reload = Reload::new_settings;
  }
}

}  // namespace

void require_good(const LiveFlags& flags) {
  require_duration(flags.duration);

  // Flags that exclude each other.
  const SourceRequest& source = flags.source;
  if (flags.monitor) require_sees_monitor(source, *flags.monitor);
  throw_if(flags.monitor && source.sequence.exposures,
           "--exposures: live with --monitor uses a single exposure; use --exposure");
  throw_if(!flags.second_camera.empty() && (flags.monitor || !flags.record.empty()),
           "--second-camera excludes --monitor, as the projector must trigger both cameras, and "
           "--record: record each camera with slipstream record");
  throw_if((flags.second_scanner || flags.live.fuse) && flags.second_camera.empty(),
           "{} needs --second-camera", flags.live.fuse ? "--fuse" : "--second-scanner");

  // A v4l2 camera has no trigger input, so only a marker frame can tell it where a cycle begins.
  throw_if(scheme_of(source.source) == "v4l2" && !flags.monitor &&
               flags.live.indexing != PatternIndexing::marker,
           "{} runs freely, so nothing keeps it in step with the projector; add --monitor N, or "
           "--indexing marker for patterns slower than half its rate",
           source.source);

  if (flags.live.most_frames == 0U) throw Error("--frames 0 is out of range; 1 or more");
  for (const std::string& file : {flags.output, flags.model}) {
    if (!file.empty()) require_cloud_ending(file);
  }

  std::set<std::string> sinks;
  for (const std::string& sink : flags.publish) {
    require_sink(sink);
    throw_if(!sinks.insert(sink).second, "--publish {} is given twice", sink);
  }
#ifdef SLIPSTREAM_VIEW
  require_good(flags.view);
#endif
}

namespace {

/// Results made of all clouds, recording and publishing.
void add_live_result_flags(const FlagGroup& command, LiveFlags& flags) {
  command.add_output(
      "-o,--output", flags.output,
      "file for the last cloud: .ply, .pcd or .xyz; - writes .ply to standard output");
  const auto track = [&flags](const std::string& text) {
    flags.live.track = tracked_shape_named(text);
  };
  command.add_read<>("--track", track,
                     "find this shape in every cloud: sphere:RADIUS (mm) or plane");
  command.add_output(
      "--model", flags.model,
      "register all clouds of a rigid turning object, alone in view, into one: .ply, .pcd or .xyz");

  command.add_output("--record", flags.record,
                     "record all frames, for replay:PATH, into a .slip file");
  add_limit_flag(command.app, flags.limit);
  command
      .add("--publish", flags.publish,
           fmt::format("publish clouds, may be repeated: {}", sink_forms()))
      ->expected(1)
      ->take_all();
}

/// How frames become clouds.
void add_live_cloud_flags(const FlagGroup& command, LiveFlags& flags) {
  command.add_named(
      "--indexing", flags.live.indexing, pattern_indexing_named, "source",
      "how frames are matched to patterns: source (its own index), counted "
      "(frame number modulo patterns) or marker (a dark or bright frame ends each cycle)");
  command.add_file("--scanner", flags.source.scanner,
                   "scanner file; default: the recording's or the virtual scanner's");
  command.add("--second-camera", flags.second_camera,
              "source of a second camera that sees the same patterns: clouds come from matches "
              "between both");
  command.add_file("--second-scanner", flags.second_scanner,
                   "scanner file of the second camera with the same projector; default: its own");
  command.add("--fuse", flags.live.fuse,
              "two cameras: instead of matching their phases, fuse the points that each measures "
              "with the projector");
  command.add("--gamma", flags.gamma,
              "response correction: scanner (from its file, if present), none, or a gamma");
  add_backend_flag(command, flags.settings);
  FlagGroup{command.app, "Valid pixels"}.add_settings(flags.settings);
  add_clean_flags(command.app, flags.settings);
  add_frame_flag(command.app, flags.settings);
}

}  // namespace

void add_live_flags(const FlagGroup& command, LiveFlags& flags) {
  SourceFlags& source = flags.source;
  source.virtual_scanner.idle_step = {0.5, 0, 0};

  // The source, and the end of the run.
  command.add("--source", source.source, source_forms());
  command.add_settings(source);
  command.add("--monitor", flags.monitor,
              "show the patterns on this monitor, see `project --list`, and take them in step");
  command.add("--no-guard", flags.no_guard,
              "with --monitor: take no guard, which shows at the start, after a pause and on "
              "request whether the rig has moved since calibration");
  command.add("--duration", flags.duration, "stop after this many seconds");
  command.add("--frames", flags.live.most_frames, "stop after this many frames");

  add_live_result_flags(command, flags);
  add_live_cloud_flags(command, flags);
#ifdef SLIPSTREAM_VIEW
  add_view_flags(command.app, flags.view);
#endif

  add_pattern_flags(command.app, source.sequence);
  add_virtual_flags(command.app, source.virtual_scanner);
  add_camera_flags(command.app, source.camera);
}

void live(const LiveFlags& flags, Output& output) {
  return_memory();
  LiveSession session(flags, output);
  const RunEnd end(flags.duration);
  SessionNews news(session, output);

  // 1. The end of the run, polled by the window or the loop below; it also prints news.
  const auto is_over = [&] {
    session.tell_news();
    news.tell_of_limit();

    if (session.projector_closed() || end.reached() || session.pipeline().failure()) return true;
    if (flags.reload && take_reload_request() && flags.reload()) return true;

    // A window stays open when the frames end, unless a number of frames was given.
    const bool at_end = flags.headless || flags.live.most_frames;
    return at_end && !session.pipeline().running();
  };

  // 2. Start, and run until the end.
  session.start();
  tell_service_manager("READY=1");
  if (flags.begun) flags.begun();

  output.document["files"] = nlohmann::json::object();

#ifdef SLIPSTREAM_VIEW
  if (!flags.headless) show_in_window(session.view_source(), flags.view, is_over, output);
#endif

  while (flags.headless && !is_over()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    news.tell_of_clouds();
    news.tell_of_source();
  }

  finish(session, news, flags, output);
  const std::string& recording = session.recording_file();
  if (is_recording(recording)) output.object("files")["recording"] = recording;
}

void add_live(const Commands& program) {
  const auto [command, flags] = program.add(
      live, "live", "reconstruct in real time from a camera, the virtual scanner or a recording");

  add_live_flags(command, flags);
  command.add("--headless", flags.headless, "no window");

  command.common({"--source", "--monitor", "--scanner", "--strategy", "--steps", "--rate",
                  "--output", "--publish", "--record", "--headless", "--exposure"});
  command.examples({"live --source virtual --rate 120 --strategy pmp --steps 4",
                    "live --source replay:scan.slip --headless --json",
                    "live --source virtual --world ideal --frames 100 --headless -o cloud.ply"});
}

void add_serve(const Commands& program) {
  const auto [command, flags] =
      program.add(serve, "serve",
                  "run live without a window from one rig file, until SIGTERM; SIGHUP rereads it");

  add_live_flags(command, flags);
  flags.command = &program.chosen;
  program.chosen.served = &flags;

  command.common({"--source", "--scanner", "--strategy", "--steps", "--rate", "--publish",
                  "--record", "--exposure"});
  command.examples({"serve rig.yaml"});
}

}  // namespace slipstream::app
