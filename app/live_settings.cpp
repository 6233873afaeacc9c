#include "app/live_settings.h"

#include <algorithm>
#include <array>
#include <charconv>

#include <fmt/format.h>

#include "slipstream/io/file.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/strategy/registry.h"

namespace slipstream::app {
namespace {

const std::vector<std::string> off_and_on{"off", "on"};

struct CameraWords {
  CameraControl which;
  const char *name, *help, *unit;
};
constexpr std::array<CameraWords, 3> camera_words{
    {{CameraControl::exposure, "exposure", "of each frame", "ms"},
     {CameraControl::gain, "gain", "of the camera, mostly dB", ""},
     {CameraControl::frame_rate, "rate", "of a camera that runs freely", "per s"}}};

std::string switch_text(bool on) {
  return off_and_on[on ? 1 : 0];
}

/// The one that was given, and the usual ones where a projector may show them.
std::vector<std::string> strategy_choices(const LiveSession& session) {
  std::vector<std::string> labels{label_of(session.strategy)};
  if (!session.patterns_can_change) return labels;
  for (const Strategy& strategy : usual_strategies()) {
    if (strategy != session.strategy) labels.push_back(label_of(strategy));
  }
  return labels;
}

double number_of(const std::string& value) {
  double number = 0;
  std::from_chars(value.data(), value.data() + value.size(), number);
  return number;
}

/// Puts a value that the setting can have into the setup; false where it is none of the setup's.
bool set(EngineSetup& setup, const LiveSession& session, const std::string& name,
         const std::string& value) {
  ReconstructSettings& settings = setup.settings;
  if (name == "strategy") {
    const bool given = value == label_of(session.strategy);
    setup.sequence.strategy = given ? session.strategy : strategy_labelled(value);
  } else if (name == "min-modulation") {
    settings.minimum_modulation = number_of(value);
  } else if (name == "keep-saturated") {
    settings.drop_saturated = value == "off";
  } else if (name == "min-component") {
    settings.clean.smallest_component = static_cast<int>(number_of(value));
  } else {
    return false;
  }
  return true;
}

/// The caller holds the mutex.
void change_locked(LiveSession& session, EngineSetup setup) {
  if (session.motion_when_seen) setup.sequence.motion = takes_motion(setup.sequence) ? 2 : 0;
  session.pipeline.change(setup);
  session.setup = setup;
  session.recorder.set_strategy(setup.sequence.strategy);
  ++session.changes;
}

/// Likewise.
void record_locked(LiveSession& session, bool on) {
  if (!on) return session.recorder.finish_recording();
  if (session.recorder.recording()) return;
  make_folder(session.view.save_to);
  session.recorder.record_to(path_named_by_time(session.view.save_to, "recording", ".slip"));
}

}  // namespace

bool takes_motion(const Sequence& sequence) {
  const Layout& layout = sequence.strategy.layout();
  const auto run = step_run(measuring_band(layout));
  return layout.bands.size() == 1 && !layout.cue && run && run->steps == layout.frames &&
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

void record(LiveSession& session, bool on) {
  const std::lock_guard lock(session.mutex);
  record_locked(session, on);
}

std::vector<RunSetting> settings_of(LiveSession& session) {
  std::vector<RunSetting> all;
  const CameraControls* const camera = session.recorder.controls();
  for (const auto& [which, name, help, unit] : camera_words) {
    const auto control = camera ? camera->control(which) : std::nullopt;
    if (!control) continue;
    all.push_back({.name = name,
                   .help = help,
                   .unit = unit,
                   .value = fmt::format("{:.6g}", control->value),
                   .least = control->least,
                   .most = control->most});
  }
  const EngineSetup setup = setup_of(session);
  const ReconstructSettings& settings = setup.settings;
  all.push_back({.name = "strategy",
                 .help = "what the projector shows",
                 .value = label_of(setup.sequence.strategy),
                 .choices = strategy_choices(session)});
  all.push_back({.name = "min-modulation",
                 .help = "least modulation of a point",
                 .unit = "grey levels of 255",
                 .value = fmt::format("{:g}", settings.minimum_modulation),
                 .most = 127});
  all.push_back({.name = "min-component",
                 .help = "fewest pixels of a connected piece",
                 .unit = "pixels",
                 .value = fmt::format("{}", settings.clean.smallest_component),
                 .most = 1e6});
  all.push_back({.name = "keep-saturated",
                 .help = "pixels with a saturated frame become points",
                 .value = switch_text(!settings.drop_saturated),
                 .choices = off_and_on});
  const auto recording = session.recorder.recording();
  all.push_back({.name = "record",
                 .help = "all frames, into a new file",
                 .value = switch_text(recording.has_value()),
                 .choices = off_and_on,
                 .state = recording ? text_of(*recording) : ""});
  return all;
}

void change_setting(LiveSession& session, const std::string& name, const std::string& value) {
  require_settable(settings_of(session), name, value);
  for (const CameraWords& words : camera_words) {
    if (name != words.name) continue;
    if (CameraControls* const camera = session.recorder.controls()) {
      camera->set_control(words.which, number_of(value));
      ++session.changes;
    }
    return;
  }
  const std::lock_guard lock(session.mutex);
  if (name == "record") return record_locked(session, value == "on");
  EngineSetup setup = session.setup;
  if (set(setup, session, name, value)) change_locked(session, std::move(setup));
}

}  // namespace slipstream::app
