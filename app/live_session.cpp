#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "app/live.h"
#include "base/numbers.h"
#include "frames/pattern_windows.h"
#include "io/file.h"
#include "io/result_files.h"
#include "reconstruct/engine_setup.h"
#include "slipstream/scan_files.h"
#include "slipstream/strategy.h"

namespace slipstream::app {
namespace {

const std::vector<std::string> off_and_on{"off", "on"};

RunSetting number(const char* name, const char* help, const char* unit, const ControlValue& value) {
  return {.name = name,
          .help = help,
          .unit = unit,
          .value = fmt::format("{:.6g}", value.value),
          .least = value.least,
          .most = value.most};
}

RunSetting off_or_on(const char* name, const char* help, bool on) {
  return {.name = name, .help = help, .value = off_and_on[on ? 1 : 0], .choices = off_and_on};
}

/// Calls visit(setting, member) for each number and switch of `settings` that can change live.
template <class Settings, class Visit>
void for_each_live_setting(Settings& settings, const Visit& visit) {
  const auto visit_live = [&](const Setting& setting, auto& member) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(member)>>) {
      if (*setting.live.help != '\0') visit(setting, member);
    }
  };

  ReconstructSettings::for_each_setting(settings, visit_live);
  CleanSettings::for_each_setting(settings.clean, visit_live);
}

/// Numbers first.
std::vector<RunSetting> live_settings_of(const ReconstructSettings& settings) {
  std::vector<RunSetting> all;
  for_each_live_setting(settings, [&](const Setting& setting, const auto& value) {
    const char* const name = setting.option;
    const auto& [help, unit, least, most] = setting.live;
    if constexpr (std::is_same_v<decltype(value), const bool&>) {
      all.push_back(off_or_on(name, help, value != setting.option_clears));
    } else {
      all.push_back(number(name, help, unit, {static_cast<double>(value), least, most}));
    }
  });

  std::ranges::stable_partition(all, std::ranges::empty, &RunSetting::choices);
  return all;
}

void change_described(ReconstructSettings& settings, const std::string& name,
                      const std::string& value) {
  for_each_live_setting(settings, [&](const Setting& setting, auto& member) {
    if (name != setting.option) return;
    using Member = std::remove_reference_t<decltype(member)>;

    if constexpr (std::is_same_v<Member, bool>) {
      member = (value == "on") != setting.option_clears;
    } else {
      member = static_cast<Member>(number_in<double>(value).value_or(0));
    }
  });
}

/// The caller holds the mutex, here and below.
void change_locked(LiveSession& session, EngineSetup setup) {
  if (session.motion_when_seen) setup.sequence.motion = takes_motion(setup.sequence) ? 2 : 0;
  session.pipeline->change(setup);
  session.setup = setup;
  session.recorder->set_strategy(setup.sequence.strategy);
  ++session.changes;
}

void set_recording(LiveSession& session, bool on) {
  if (!on) return session.recorder->finish_recording();
  if (session.recorder->recording()) return;
  make_folder(session.flags.view.save_to);
  session.recorder->record_to(path_named_by_time(session.flags.view.save_to, "recording", ".slip"));
}

/// The maps of a session's clouds for PublishedRun; callable from any sink.
class CloudMaps {
 public:
  explicit CloudMaps(LiveSession& session) : session_(session) {}

  Image<std::uint8_t> phase(const LiveCloud& cloud) {
    const std::lock_guard lock(mutex_);
    const auto frames = measure(cloud);
    if (!frames) return {};

    const double least = least_modulation(engine_->setup().settings, frames->full_scale());
    Image<std::uint8_t> phase(frames->size());

    // The wrapped phase, 0 to 2 pi, as grey levels 1 to 255; 0 stands for a pixel without a phase.
    std::transform(maps_.wrapped_phase.begin(), maps_.wrapped_phase.end(), maps_.modulation.begin(),
                   phase.begin(), [&](float angle, float modulation) {
                     const float step = angle * (255 / (2 * std::numbers::pi_v<float>));
                     if (!(modulation >= least) || !(step >= 0)) return std::uint8_t{0};
                     return static_cast<std::uint8_t>(1 + std::min(step, 254.0F));
                   });

    return phase;
  }

  std::optional<Uncertainty> uncertainty(const LiveCloud& cloud) {
    const std::lock_guard lock(mutex_);
    const auto frames = measure(cloud);
    if (!frames) return std::nullopt;
    return engine_->uncertainty(cloud.cloud, maps_, *frames);
  }

 private:
  /// The frames to make maps from; empty if they belong to another sequence than the current one.
  std::optional<FrameViews> measure(const LiveCloud& cloud) {
    // The engine is built again when the setup has changed since the last cloud.
    if (const std::uint64_t changes = session_.changes; !engine_ || changes != changes_) {
      EngineSetup setup = setup_of(session_);
      motion_ = std::exchange(setup.sequence.motion, 0);
      if (!session_.flags.second_camera.empty()) {  // the points are not of one camera's phases
        setup.scanner = without_geometry(setup.scanner.camera.size, setup.scanner.projector.size,
                                         setup.scanner.photometry);
      }

      engine_.emplace(setup);
      changes_ = changes;
    }

    // A window with extra motion frames holds the cycle in its middle.
    const FrameViews window = views_of(cloud.frames);
    if (window.count() != frame_count(engine_->setup().sequence) + motion_) return std::nullopt;
    const FrameViews cycle = middle_cycle(window, cloud.first_pattern, motion_);
    const FrameViews& frames = engine_->merged(cycle);
    engine_->maps(frames, maps_);
    return frames;
  }

  LiveSession& session_;
  std::mutex mutex_;
  std::optional<Engine> engine_;
  std::uint64_t changes_ = 0;
  int motion_ = 0;
  Maps maps_;
};

std::string trouble_of(const LiveSession& session) {
  const LivePipeline& pipeline = *session.pipeline;
  if (const auto failure = pipeline.failure()) return "the pipeline has failed";
  const std::string state = pipeline.statistics().source_state;
  if (!state.empty()) return state;

  for (const SinkStatistics& sink : session.publisher.statistics()) {
    if (!sink.error.empty()) return fmt::format("{}: {}", sink.name, sink.error);
  }
  return pipeline.running() ? "" : "the source has ended";
}

std::string save_newest(LiveSession& session) {
  require_saveable(session);

  // One save per second is enough: a page's button may be pressed by several people.
  const std::lock_guard lock(session.saving);
  throw_if(std::chrono::steady_clock::now() - session.saved < std::chrono::seconds(1),
           "saved a moment ago");

  const Pooled<LiveCloud> newest = session.pipeline->newest();
  throw_if(!newest, "no cloud to save yet");

  std::string folder =
      save_in_new_folder(views_of(newest->frames), setup_of(session), session.flags.view.save_to,
                         remarks_about(session.pipeline->statistics().findings));

  session.saved = std::chrono::steady_clock::now();
  return folder;
}

}  // namespace

void require_saveable(const LiveSession& session) {
  throw_if(!session.flags.second_camera.empty(),
           "with --second-camera nothing is saved while it runs; the last cloud is written by -o");
}

std::vector<std::string> strategy_labels(const Strategy& given) {
  std::vector<std::string> labels;
  for (const Strategy& choice : strategies_beside(given)) labels.push_back(label_of(choice));
  return labels;
}

bool takes_motion(const Sequence& sequence) {
  const Layout& layout = sequence.strategy.layout();
  const auto run = step_run(measuring_band(layout));
  const bool is_alone = layout.bands.size() == 1 && !layout.cue;

  // Two sinusoids that share the modulation of the same frames.
  const bool is_multiplexed =
      layout.unwrapping == Unwrapping::vote && measuring_band(layout).share < 1;

  return (is_alone || is_multiplexed) && run && run->steps == layout.frames &&
         sequence.exposures.size() == 1 && !sequence.both_axes && !sequence.marker;
}

EngineSetup setup_of(LiveSession& session) {
  const std::lock_guard lock(session.mutex);
  return session.setup;
}

void change_setup(LiveSession& session, const EngineSetup& setup) {
  const std::lock_guard lock(session.mutex);
  change_locked(session, setup);
}

std::vector<RunSetting> settings_of(LiveSession& session) {
  std::vector<RunSetting> all;
  const CameraControls* const camera = session.recorder->controls();
  for (const auto& [which, name, help, unit, shown_as] : camera_controls) {
    const auto control = camera ? camera->control(which) : std::nullopt;
    if (control) all.push_back(number(name, help, unit, *control));
  }

  const EngineSetup setup = setup_of(session);
  all.push_back({.name = "strategy",
                 .help = "patterns shown by the projector",
                 .value = label_of(setup.sequence.strategy),
                 .choices = session.patterns_can_change ? strategy_labels(session.strategy)
                                                        : std::vector{label_of(session.strategy)}});
  for (RunSetting& setting : live_settings_of(setup.settings)) all.push_back(std::move(setting));

  const auto recording = session.recorder->recording();
  all.push_back(off_or_on("record", "record all frames into a new file", recording.has_value()));
  if (recording) all.back().state = text_of(*recording);
  return all;
}

void change_setting(LiveSession& session, const std::string& name, const std::string& value) {
  require_settable(settings_of(session), name, value);
  const auto control = std::ranges::find(camera_controls, name, &CameraControlWords::name);

  // 1. A control of the camera.
  if (control != camera_controls.end()) {
    session.recorder->controls()->set_control(control->which, number_in<double>(value).value_or(0));
    ++session.changes;
    return;
  }

  // 2. Recording on or off.
  const std::lock_guard lock(session.mutex);
  if (name == "record") return set_recording(session, value == "on");

  // 3. A setting of the reconstruction, or the strategy.
  EngineSetup setup = session.setup;
  if (name == "strategy") {
    const bool given = value == label_of(session.strategy);
    setup.sequence.strategy = given ? session.strategy : strategy_labelled(value);
  }
  change_described(setup.settings, name, value);
  change_locked(session, std::move(setup));
}

void open_sinks(LiveSession& session, const std::function<nlohmann::json()>& document) {
  const Scanner& scanner = session.setup.scanner;
  for (const std::string& name : session.flags.publish) {
    const auto maps = std::make_shared<CloudMaps>(session);
    PublishedRun run{
        .camera = scanner.camera,
        .scanner = has_geometry(scanner) ? text_of(scanner) : std::string(),
        .has_points = has_geometry(scanner),
        .statistics =
            [document] {  // paths need not be UTF-8
              return document().dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
            },
        .trouble = [&session] { return with_flags(trouble_of(session)); },
        .save = [&session] { return save_newest(session); },
        .phase = [maps](const LiveCloud& cloud) { return maps->phase(cloud); },
        .sequence = [&session] { return setup_of(session).sequence; },
        .settings = [&session] { return settings_of(session); },
        .change = [&session](const std::string& setting,
                             const std::string& value) { change_setting(session, setting, value); },
        .limit = session.flags.limit,
    };

    // Sigma needs the noise variance and the phases of one camera.
    if (scanner.photometry.noise_variance && session.flags.second_camera.empty()) {
      run.uncertainty = [maps](const LiveCloud& cloud) { return maps->uncertainty(cloud); };
    }

    session.publisher.add(name, open_sink(name, std::move(run)));
  }
}

std::string save_in_new_folder(const FrameViews& frames, const EngineSetup& setup,
                               const std::string& parent, const std::vector<std::string>& remarks) {
  Sequence sequence = setup.sequence;
  throw_if(frames.count() != frame_count(sequence),
           "the displayed frames do not match the selected strategy");

  sequence.projector = setup.scanner.projector.size;
  sequence.marker = false;
  const fs::path folder = path_named_by_time(parent, "scan", "");

  // Without a scanner only the frames are worth saving.
  if (!has_geometry(setup.scanner)) {
    save_scan(folder, frames, sequence, std::nullopt);
    return folder.string();
  }

  Cloud cloud;
  Maps maps;
  Engine(setup).cloud_and_maps(frames, cloud, maps);
  make_folder(folder);

  // Merged exposures are not frames as taken, so they are left out.
  if (!frames.merged()) save_scan(folder, frames, sequence, setup.scanner);
  write_results({.cloud = folder / "cloud.ply",
                 .depth = folder / "depth.tiff",
                 .coordinate = folder / "coordinate.tiff",
                 .phase = folder / "phase.tiff",
                 .modulation = folder / "modulation.tiff",
                 .mean = folder / "mean.tiff",
                 .preview = folder / "preview.png"},
                cloud, maps, {.remarks = remarks});
  return folder.string();
}

}  // namespace slipstream::app
