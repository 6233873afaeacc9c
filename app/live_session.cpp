#include "app/live_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "app/rig_guard.h"
#include "app/session_outputs.h"
#include "app/session_settings.h"
#include "frames/paired_source.h"
#include "frames/pattern_windows.h"
#include "response/exposure_advice.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {
namespace {

/// Setup for the source's scanner, with the gamma chosen by flag. Without a known scanner: pictures
/// only, no points.
EngineSetup setup_from(const NamedSource& opened, const LiveFlags& flags, Output& output) {
  const std::string& file = opened.scanner_name;
  const Size camera = opened.frames->format().size, projector = opened.sequence.projector;

  EngineSetup setup{opened.scanner ? completed(*opened.scanner, file, camera, projector)
                                   : without_geometry(camera, projector),
                    opened.sequence, flags.settings};

  // Points need a scanner: refuse flags that ask for points if it is unknown.
  if (opened.scanner) {
    require_ambient_known(setup, file);
  } else {
    const std::string& wants_points = !flags.output.empty() ? flags.output : flags.model;
    throw_if(
        !wants_points.empty() || flags.live.track,
        "{}: no scanner is known for {}, so no points can be made; name its file with --scanner",
        wants_points.empty() ? "--track" : wants_points, flags.source.source);
    output.say(
        "no scanner is known for {}: showing pictures without points; name its file with --scanner",
        flags.source.source);
  }

  require_valid(setup.settings.clean);
  const GammaChoice gamma = choose_gamma(flags.gamma, setup.scanner.photometry.response);
  setup.scanner.photometry.response = gamma.response;
  if (!gamma.sentence.empty()) output.say("{}", gamma.sentence);

  return setup;
}

/// Exposures become whole refreshes of the monitor: a projector's light changes within each.
void expose_for_whole_refreshes(const MonitorProjector& projector, FrameSource& camera,
                                Output& output) {
  CameraControls* const controls = camera.controls();
  const auto exposure = controls ? controls->control(CameraControl::exposure) : std::nullopt;
  if (!exposure) return;

  const double refresh = 1e3 / projector.refresh_hz;
  const double refreshes = std::max(1.0, std::round(exposure->value / refresh));
  if (std::abs(exposure->value - refreshes * refresh) > 0.01 * refresh) {
    controls->set_control(CameraControl::exposure, refreshes * refresh);
    output.say("exposure {:.4g} ms: {} of the monitor's refreshes", refreshes * refresh, refreshes);
  }
}

/// Puts the camera in step with the patterns on a monitor: from here on it delivers one frame per
/// pattern shown.
SteppedSource& step_with(const MonitorProjector& projector, bool triggered,
                         const std::vector<Image<std::uint8_t>>& guard, NamedSource& opened) {
  auto stepped =
      std::make_unique<SteppedSource>(*projector.sink, std::move(opened.frames),
                                      pictures_to_show(opened.sequence), triggered, guard);
  SteppedSource& source = *stepped;
  opened.frames = std::move(stepped);
  return source;
}

void tell_steps(const SteppedSource& source, Output& output) {
  const auto ms = [](std::chrono::duration<double, std::milli> time) { return time.count(); };
  const double begins = ms(source.delay().begins), ends = ms(source.delay().ends),
               hold = ms(source.hold());

  output.say("patterns reach a frame {:.0f} to {:.0f} ms after they are shown; {:.0f} ms each",
             begins, ends, hold);
  output.object("monitor") = described("begins_ms", begins, "ends_ms", ends, "hold_ms", hold);
}

/// Adds the second camera's pictures to the frames of the first; returns its scanner.
Scanner add_second_camera(const LiveFlags& flags, SourceRequest request, NamedSource& opened,
                          Output& output) {
  const std::string& name = flags.second_camera;
  request.source = name;
  request.scanner = flags.second_scanner;
  if (scheme_of(name) == "virtual") {
    request.world =
        seen_from_second(request.world ? *request.world : world_from(flags.source.virtual_scanner));
    request.while_rendering = [](double) {};  // the first camera's bar is enough
  }

  NamedSource second = open(request, output);

  // The frames of both cameras are matched one by one, so all must agree.
  throw_if(second.sequence.strategy != opened.sequence.strategy ||
               axes_of(second.sequence) != axes_of(opened.sequence),
           "{}: its sequence differs from the first camera's; both must see one projector", name);
  throw_if(opened.in_colour || second.in_colour, "--second-camera: both cameras must be grey");
  throw_if(opened.sequence.exposures.size() > 1,
           "--second-camera: live matches frames of one exposure; use --exposure");
  throw_if(!opened.scanner, "{}: its scanner is unknown; name its file with --scanner",
           flags.source.source);
  throw_if(!second.scanner, "{}: its scanner is unknown; name its file with --second-scanner",
           name);

  Scanner scanner = completed(*second.scanner, second.scanner_name, second.frames->format().size,
                              second.sequence.projector);
  auto& response = scanner.photometry.response;
  response = choose_gamma(flags.gamma, response).response;
  opened.frames =
      std::make_unique<PairedSource>(std::move(opened.frames), std::move(second.frames));
  return scanner;
}

/// The request to the source, from the flags.
SourceRequest live_request(const LiveFlags& flags) {
  SourceRequest request = request_from(flags.source);
  request.marker = flags.live.indexing == PatternIndexing::marker;
  request.as_taken = true;  // stored with the recording
  if (!flags.headless) request.before_rendering = require_desktop;

  // Repeat the first cycle until all is rendered, for a first cloud at once. Not with two cameras,
  // which move in step, nor for a number of frames as fast as possible: each run gives the same.
  const bool repeats =
      flags.second_camera.empty() && (request.rate.value_or(0) > 0 || !flags.live.most_frames);
  request.first_rest = repeats ? FirstRest::until_rendered : FirstRest::once;

  return request;
}

/// Whether extra frames can compensate motion. Exceptions: a replay may end after its first cycle;
/// the channels of a colour picture move together; the published tables are of one cycle.
bool takes_extra_frames(const SourceRequest& request, const NamedSource& opened,
                        const EngineSetup& setup) {
  const bool is_published = setup.settings.engine == EngineKind::reference &&
                            setup.settings.phase_method == PhaseMethod::tables;

  return scheme_of(request.source) != "replay" && !opened.in_colour && !request.sequence.motion &&
         setup.sequence.motion == 0 && takes_motion(setup.sequence) && !is_published;
}

/// The frames of the opened source, which can be recorded.
std::unique_ptr<RecordedSource> recorded_source(NamedSource& opened, const SourceRequest& request,
                                                const EngineSetup& setup, const FileLimit& limit) {
  const RecordingHeader header{
      .format = opened.frames->format(),
      .frame_rate = request.rate.value_or(0),
      .sequence = opened.sequence,
      .scanner = has_geometry(setup.scanner) ? std::optional(setup.scanner) : std::nullopt,
      .in_colour = opened.in_colour,
      .white = opened.white};
  return std::make_unique<RecordedSource>(std::move(opened.frames), header, limit);
}

}  // namespace

LiveSession::LiveSession(LiveFlags flags, Output& output)
    : flags_(std::move(flags)), output_(output) {
  require_good(flags_);
  LiveSettings settings = flags_.live;
  SourceRequest request = live_request(flags_);

  // 1. Open the projector first: the patterns have its size.
  projector_ = open_projector(flags_.monitor);
  if (projector_.sink != nullptr && !request.sequence.projector) {
    request.sequence.projector = projector_.sink->size();
  }

  // 2. Open the source, or both cameras, and set up reconstruction for its scanner.
  NamedSource opened = open(request, output_);
  if (has_two_cameras())
    settings.second_camera = add_second_camera(flags_, request, opened, output_);

  if (opened.sequence.marker) settings.indexing = PatternIndexing::marker;
  setup_ = setup_from(opened, flags_, output_);
  strategy_ = setup_.sequence.strategy;

  // 3. Take extra frames to compensate motion where possible.
  motion_when_seen_ = !settings.second_camera && takes_extra_frames(request, opened, setup_);
  settings.motion_when_seen = motion_when_seen_;
  settings.colour = opened.colour;
  if (motion_when_seen_) setup_.sequence.motion = 2;

  // 4. In step with the monitor; from here on the source shows the patterns.
  if (flags_.monitor) {
    const bool triggered = request.camera.trigger == "Software";
    expose_for_whole_refreshes(projector_, *opened.frames, output_);

    std::vector<Image<std::uint8_t>> guard;
    if (!flags_.no_guard && !has_two_cameras()) guard = guard_pictures(setup_, opened);
    stepped_ = &step_with(projector_, triggered, guard, opened);
    if (stepped_->has_guard()) rig_.emplace(*stepped_, output_);
  }

  // 5. Recording: the pipeline reads frames through it, whether or not they are written.
  auto source = recorded_source(opened, request, setup_, flags_.limit);
  source_ = source.get();

  // 6. The pipeline. Sinks hold clouds until they have published them, so it needs that many more.
  settings.model = !flags_.model.empty();
  if (!flags_.publish.empty()) {
    settings.held_clouds += flags_.publish.size() * Publisher::held_clouds;
    settings.on_cloud = [this](const Pooled<LiveCloud>& cloud) { publisher_.publish(cloud); };
  }

  pipeline_ =
      std::make_unique<LivePipeline>(colours_apart(std::move(source), opened), setup_, settings);
}

void LiveSession::start() {
  open_sinks();
  tell_news();
  if (!flags_.record.empty()) {
    recording_file_ = file_to_write(flags_.record);
    source_->record_to(recording_file_);
  }

  const std::lock_guard lock(mutex_);  // sinks may already change the pipeline
  pipeline_->start();
  if (stepped_ != nullptr) tell_steps(*stepped_, output_);
}

void LiveSession::stop() {
  pipeline_->stop();
  publisher_.finish();
  if (rig_) rig_->finish(setup());
}

void LiveSession::tell_news() {
  if (rig_) rig_->look(setup());
  publisher_.tell([&](const std::string& line) { output_.say("{}", line); },
                  [&](const std::string& line) { output_.warn(line); });
}

nlohmann::json LiveSession::document() const {
  nlohmann::json document = as_json(pipeline_->statistics());
  document["findings"] = pipeline_->findings();
  document["sinks"] = as_json(sinks(), [](const SinkStatistics& sink) {
    return described("name", sink.name, "published", sink.published, "dropped", sink.dropped,
                     "error", sink.error);
  });

  document["source"] = flags_.source.source;
  if (const auto& frame = wanted_frame(flags_.settings)) {
    document["frame"] = json_of(*frame_after({}, *frame));
  }
  return document_with_flags(std::move(document));
}

#ifdef SLIPSTREAM_VIEW
view::ViewSource LiveSession::view_source() {
  const std::string& name = flags_.source.source;
  view::ViewSource source = view::live_source(*pipeline_, setup(), patterns_can_change_);

  source.wording = &with_flags;
  if (const auto& frame = wanted_frame(flags_.settings)) source.frame = frame_after({}, *frame);
  source.title = fmt::format("slipstream live: {}", name);
  source.waits_for = fmt::format("waiting for the first {} frames of {}",
                                 cycle_length(source.setup->sequence), name);

  // The camera's controls beside the picture.
  source.camera = source_->controls();
  source.camera_region =
      fmt::format("{} pixels; set by --region at the start", text_of(source_->format().size));

  // Changes from the window go to the session; changes from elsewhere come back to the window.
  source.change = [this](const EngineSetup& setup) { change(setup); };
  source.changed = [this, seen = changes()]() mutable {
    const std::uint64_t before = std::exchange(seen, changes());
    return before == seen ? std::nullopt : std::optional(setup());
  };

  // Save, record and the advice on exposure.
  source.save = [this](const view::ShownCloud& cloud, const EngineSetup& setup) {
    return save(cloud.frames, *cloud.sequence, setup);
  };
  source.record = [this](bool on) { change("record", on ? "on" : "off"); };
  source.recording = [this] {
    const auto recording = source_->recording();
    return recording ? text_of(*recording) : std::string();
  };

  if (rig_) {
    source.check_rig = [this] { change("guard", "on"); };
    source.rig = [this] { return rig_->state(); };
  }

  source.best_exposure = [](const view::ShownCloud& cloud, double exposure) {
    Sequence sequence = *cloud.sequence;
    sequence.exposures = {exposure};
    return exposure_advice(cloud.frames, sequence).proposed.front().exposures.front();
  };

  return source;
}
#endif

}  // namespace slipstream::app
