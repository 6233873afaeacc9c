#include "app/live.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/process.h"
#include "app/scan_input.h"
#include "slipstream/base/error.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/frames/pattern_windows.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/recording.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/publish/cloud_sink.h"
#include "slipstream/publish/publisher.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/reconstruct/picture_report.h"
#include "slipstream/response/gamma_choice.h"

namespace slipstream::app {
namespace {

/// What the engine is made of: the source's scanner, corrected for the gamma that the flags choose.
/// Where none is known the pictures alone are shown.
EngineSetup setup_from(const NamedSource& opened, const LiveFlags& flags, Output& output) {
  const std::string& file = opened.scanner_name;
  const Size camera = opened.frames->format().size, projector = opened.sequence.projector;
  EngineSetup setup{opened.scanner ? completed(*opened.scanner, file, camera, projector)
                                   : without_geometry(camera, projector),
                    opened.sequence, flags.settings};
  if (opened.scanner) {
    require_ambient_known(setup, file);
  } else if (!flags.output.empty() || !flags.model.empty() || flags.live.track) {
    throw Error(
        fmt::format("{}: no scanner is known for {}, so there are no points; name its file "
                    "with --scanner",
                    !flags.output.empty()  ? flags.output
                    : !flags.model.empty() ? flags.model
                                           : "--track",
                    flags.source.request.source));
  } else {
    output.say("no scanner is known for {}: pictures without points; --scanner names its file",
               flags.source.request.source);
  }
  require_valid(setup.settings.clean);
  const GammaChoice gamma = choose_gamma(flags.gamma, setup.scanner.photometry.response);
  setup.scanner.photometry.response = gamma.response;
  if (!gamma.sentence.empty()) output.say("{}", gamma.sentence);
  return setup;
}

nlohmann::json json_of(const Latency& latency) {
  return {{"p50", latency.p50}, {"p99", latency.p99}, {"max", latency.max}};
}

nlohmann::json json_of(const ObjectTrack& track) {
  const auto three = [](const Eigen::Vector3d& v) { return std::array{v.x(), v.y(), v.z()}; };
  nlohmann::json told{{"found", track.found},
                      {"looked", track.looked},
                      {"missed", track.missed},
                      {track.shape.radius ? "centre_mm" : "place_mm", three(track.place)},
                      {"residual_mm", track.residuals.rms},
                      {"points", track.residuals.points},
                      {"velocity_mm_per_s", three(track.velocity)},
                      {"speed_mm_per_s", track.velocity.norm()}};
  if (!track.shape.radius) told["normal"] = three(track.normal);
  return told;
}

nlohmann::json json_of(const ModelStatistics& model) {
  return {{"views", model.views},   {"left_out", model.left_out}, {"missed", model.missed},
          {"points", model.points}, {"rms_mm", model.rms},        {"view_ms", model.milliseconds}};
}

nlohmann::json json_of(const std::vector<SinkStatistics>& sinks) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& [name, published, dropped, error] : sinks) {
    list.push_back(
        {{"name", name}, {"published", published}, {"dropped", dropped}, {"error", error}});
  }
  return list;
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
          {"cleaned", app::json_of(statistics.cleaned)},
          {"motion", statistics.motion},
          {"backend", statistics.backend},
          {"seconds", statistics.seconds},
          {"latency_ms", json_of(statistics.latency)},
          {"screen_latency_ms", json_of(statistics.screen_latency)},
          {"stages", std::move(stages)}};
}

void tell_news(Publisher& publisher, Output& output) {
  publisher.tell([&](const std::string& line) { output.say("{}", line); },
                 [&](const std::string& line) { output.warn(line); });
}

/// What has been told of the clouds.
struct ToldNews {
  std::vector<LiveFinding> findings{};
  bool gpu_failure = false;
};

void tell_news(const LivePipeline& pipeline, ToldNews& told, Output& output) {
  tell_news(pipeline.findings(), told.findings, output);
  if (told.gpu_failure) return;
  told.gpu_failure = warn_of_gpu(pipeline.gpu_failure(), output);
}

/// Tells meanwhile whatever the source and the check have to say, once.
void wait_until_over(LiveSession& session, ToldNews& news, Output& output) {
  std::string told;
  while (!session.is_over()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    tell_news(session.pipeline, news, output);
    const std::string state = session.recorder.state();
    if (state == told) continue;
    tell_service_manager("STATUS=" + state);
    if (state.empty()) {
      output.say("the source is well again");
    } else {
      output.warn(state);
    }
    told = state;
  }
}

/// Runs the session to its end; what a stage threw comes out here.
void run_session(LiveSession& session, [[maybe_unused]] bool headless, ToldNews& news,
                 Output& output) {
#ifdef SLIPSTREAM_VIEW
  if (!headless) {
    show_in_window(session, output);
    return;
  }
#endif
  wait_until_over(session, news, output);
}

/// What the pictures of the newest scan say, where there is no scanner to make points of them.
void tell_pictures(const LiveSession& session, Output& output) {
  const Pooled<LiveCloud> last = session.pipeline.newest();
  if (!last) return;
  const FrameViews frames = views_of(last->frames);
  Maps maps;
  Engine engine(session.setup);
  engine.maps(frames, maps);
  const PictureReport report = picture_report(engine.merged(frames), maps, session.setup.settings);
  const auto counts = count_by_validity(report.validity);
  const double all = static_cast<double>(report.validity.pixel_count());
  const auto count_of = [&](Validity kind) { return counts[static_cast<std::size_t>(kind)]; };
  output.say(
      "pixels: {:.1f} % measured, {:.1f} % too dark, {:.1f} % saturated; median modulation "
      "{:.1f} grey levels of 255",
      100 * static_cast<double>(count_of(Validity::valid)) / all,
      100 * static_cast<double>(count_of(Validity::too_dark)) / all,
      100 * static_cast<double>(count_of(Validity::saturated)) / all, report.modulation);
  output.document["pixels"] = {{"measured", count_of(Validity::valid)},
                               {"too_dark", count_of(Validity::too_dark)},
                               {"saturated", count_of(Validity::saturated)},
                               {"median_modulation", report.modulation}};
}

void write_model(const ModelPoints& model, const std::string& file, Output& output) {
  if (model.cloud.z.empty()) {
    throw WorldError(fmt::format("{}: no cloud came that a model could be made of", file));
  }
  write_cloud(file, model.cloud, {.normals = &model.normals});
  output.say("model: {} points in {}", model.cloud.size().width, file);
  output.object("files")["model"] = file;
}

/// What the session has measured until now.
nlohmann::json document_of(const LiveSession& session, const Publisher& publisher) {
  const LiveStatistics statistics = session.pipeline.statistics();
  nlohmann::json document = json_of(statistics);
  if (statistics.track) document["track"] = json_of(*statistics.track);
  if (statistics.model) document["model"] = json_of(*statistics.model);
  document["findings"] = app::json_of(session.pipeline.findings());
  document["sinks"] = json_of(publisher.statistics());
  document["source"] = session.flags.source.request.source;
  document["source_state"] = statistics.source_state;
  return document;
}

/// What the session measured, and what is to be kept of its last cloud.
void write_results(LiveSession& session, const Publisher& publisher, Output& output) {
  const LiveFlags& flags = session.flags;
  const LiveStatistics statistics = session.pipeline.statistics();
  output.say("{}", text_of(statistics));
  for (const SinkStatistics& sink : publisher.statistics()) {
    output.say("{}: {} clouds, {} dropped", sink.name, sink.published, sink.dropped);
  }
  output.document.update(document_of(session, publisher));
  if (const auto failure = session.pipeline.failure()) std::rethrow_exception(failure);
  if (!has_geometry(session.setup.scanner)) tell_pictures(session, output);
  if (!flags.output.empty()) {
    const Pooled<LiveCloud> last = session.pipeline.newest();
    if (!last)
      throw WorldError(fmt::format("{}: no cloud came that could be written", flags.output));
    write_cloud(flags.output, last->cloud, {.remarks = doubts(statistics.findings)});
    output.say("cloud: {}", flags.output);
    output.object("files")["cloud"] = flags.output;
  }
  if (!flags.model.empty()) write_model(session.pipeline.model(), flags.model, output);
#ifdef SLIPSTREAM_VIEW
  draw_newest(session, flags.headless, output);
#endif
}

}  // namespace

void require_good(const LiveFlags& flags) {
  require_duration(flags.duration);
  if (flags.live.most_frames == 0U) throw Error("--frames 0 is out of range; 1 or more");
  for (const std::string& file : {flags.output, flags.model}) {
    if (!file.empty()) require_cloud_ending(file);
  }
  std::set<std::string> sinks;
  for (const std::string& sink : flags.publish) {
    require_sink(sink);
    if (!sinks.insert(sink).second) throw Error(fmt::format("--publish {} is given twice", sink));
  }
#ifdef SLIPSTREAM_VIEW
  require_good(flags.view);
#else
  if (!flags.headless) throw Error("this build has no viewer; add --headless");
#endif
}

void live(const LiveFlags& flags, Output& output) {
  require_good(flags);
  LiveSettings settings = flags.live;
  SourceRequest request = request_from(flags.source);
  request.marker = settings.indexing == PatternIndexing::marker;
  request.as_taken = true;  // recorded so
  if (request.world && !flags.headless) {
    output.say("rendering what the virtual camera sees: seconds with --world ideal, else a minute");
  }
  NamedSource opened = open_source(request);
  if (!opened.warning.empty()) output.warn(opened.warning);
  if (opened.sequence.marker) settings.indexing = PatternIndexing::marker;
  EngineSetup setup = setup_from(opened, flags, output);
  const std::string scheme = scheme_of(request.source);
  // A replay may end with its first cycle; the channels of a picture in colour move with each
  // other.
  settings.motion_when_seen = scheme != "replay" && !opened.in_colour && !request.sequence.motion &&
                              setup.sequence.motion == 0 && takes_motion(setup.sequence);
  if (settings.motion_when_seen) setup.sequence.motion = 2;

  const RecordingHeader header{
      .format = opened.frames->format(),
      .frame_rate = request.rate.value_or(0),
      .sequence = opened.sequence,
      .scanner = has_geometry(setup.scanner) ? std::optional(setup.scanner) : std::nullopt,
      .in_colour = opened.in_colour,
      .white = opened.white};
  auto source = std::make_unique<RecordedSource>(std::move(opened.frames), header);
  RecordedSource& recorder = *source;
  settings.model = !flags.model.empty();
  Publisher publisher;
  if (!flags.publish.empty()) {
    settings.held_clouds += flags.publish.size() * Publisher::held_clouds;
    settings.on_cloud = [&](const Pooled<LiveCloud>& cloud) { publisher.publish(cloud); };
  }
  LivePipeline pipeline(colours_apart(std::move(source), opened), setup, settings);

  const RunEnd end(flags.duration);
  LiveSession session{.flags = flags,
                      .pipeline = pipeline,
                      .recorder = recorder,
                      .setup = setup,
                      .is_over =
                          [&] {
                            tell_news(publisher, output);
                            if (hung_up() && flags.hung_up && !flags.hung_up()) end.forget_signal();
                            const bool at_end = flags.headless || settings.most_frames;
                            return end.reached() || pipeline.failure() ||
                                   (at_end && !pipeline.running());
                          },
                      .patterns_can_change = scheme != "virtual" && scheme != "replay",
                      .motion_when_seen = settings.motion_when_seen,
                      .strategy = setup.sequence.strategy};
  const std::unique_ptr<Publisher, void (*)(Publisher*)> before_the_session_ends(
      &publisher, [](Publisher* ending) { ending->finish(); });
  open_sinks(
      session, [&] { return document_of(session, publisher); }, publisher);
  tell_news(publisher, output);
  if (!flags.record.empty()) recorder.record_to(flags.record);
  {
    const std::lock_guard lock(session.mutex);  // sinks may change it already
    pipeline.start();
  }
  tell_service_manager("READY=1");
  if (flags.begun) flags.begun();
  output.document["files"] = nlohmann::json::object();
  ToldNews news;
  run_session(session, flags.headless, news, output);
  pipeline.stop();
  publisher.finish();
  tell_news(publisher, output);
  tell_news(pipeline, news, output);

  std::exception_ptr unfinished;
  try {
    recorder.finish_recording();  // before what may end the program; begun in the window too
  } catch (const WorldError&) {
    unfinished = std::current_exception();
  }
  write_results(session, publisher, output);
  if (unfinished) std::rethrow_exception(unfinished);
  for (const SinkStatistics& sink : publisher.statistics()) {
    if (!sink.error.empty()) throw WorldError(fmt::format("{}: {}", sink.name, sink.error));
  }
  if (is_recording(flags.record)) output.object("files")["recording"] = flags.record;
}

void add_live_flags(const FlagGroup& command, LiveFlags& flags) {
  SourceRequest& request = flags.source.request;
  flags.source.world.idle_motion = {0.5, 0, 0};
  command.add("--source", request.source, source_forms());
  command.add("--rate", request.rate,
              "frames per second; 0: as fast as it goes; else the source's own");
  command.add("--loop", request.loop, "a recording begins again at its end");
  command.add("--duration", flags.duration, "seconds, then it ends");
  command.add("--frames", flags.live.most_frames, "so many frames, then it ends");
  command.add_output("-o,--output", flags.output, "the last cloud: .ply, .pcd or .xyz");
  command.add_read<>(
      "--track",
      [&flags](const std::string& text) { flags.live.track = tracked_shape_named(text); },
      "a thing of known form that every cloud is searched for: sphere:RADIUS (mm) or plane");
  command.add_output("--model", flags.model,
                     "all clouds made one, of a rigid object that turns and that they show alone: "
                     ".ply, .pcd or .xyz");
  command.add_output("--record", flags.record, "all frames, for replay:PATH");
  command
      .add("--publish", flags.publish,
           fmt::format("where clouds go besides, once for each: {}", sink_forms()))
      ->expected(1)
      ->take_all();
  command.add_named("--indexing", flags.live.indexing, pattern_indexing_named, "told",
                    "how it is known which pattern a frame shows: told (by the source), counted "
                    "(frames modulo patterns) or marker (a dark or bright frame ends each cycle)");
  command.add_file("--scanner", request.scanner,
                   "scanner file; where not that of the recording or of the virtual scanner");
  command.add("--gamma", flags.gamma,
              "the response the phase is corrected for: scanner (as its file says, if it "
              "does), none, or a number");
  add_backend_flag(command, flags.settings);
  add_point_flags(command.app, flags.settings);
  add_clean_flags(command.app, flags.settings);
#ifdef SLIPSTREAM_VIEW
  add_view_flags(command.app, flags.view);
#endif
  add_pattern_flags(command.app, request.sequence);
  add_virtual_flags(command.app, flags.source.world);
  add_camera_flags(command.app, request.camera);
}

void add_live(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, live, "live",
                  "cameras, virtual scanner or recording to clouds, as frames come");
  add_live_flags(command, flags);
  command.add("--headless", flags.headless, "no window");
  command.app.footer(
      "Examples:\n  slipstream live --source virtual --rate 120 --strategy pmp --steps 4\n  "
      "slipstream live --source replay:scan.slip --headless --json\n  slipstream live --source "
      "virtual --frames 100 --headless -o cloud.ply");
}

}  // namespace slipstream::app
