#include "app/live_settings.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "slipstream/base/number_text.h"
#include "slipstream/codes/registry.h"
#include "slipstream/io/file.h"
#include "slipstream/io/saved_scan.h"

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

/// The one that was given, and the usual ones where a projector may show them.
std::vector<std::string> strategy_choices(const LiveSession& session) {
  std::vector<std::string> labels{label_of(session.strategy)};
  if (!session.patterns_can_change) return labels;
  for (const Strategy& strategy : usual_strategies()) {
    if (strategy != session.strategy) labels.push_back(label_of(strategy));
  }
  return labels;
}

/// The caller holds the mutex, as of the next two.
void change_locked(LiveSession& session, EngineSetup setup) {
  if (session.motion_when_seen) setup.sequence.motion = takes_motion(setup.sequence) ? 2 : 0;
  session.pipeline.change(setup);
  session.setup = setup;
  session.recorder.set_strategy(setup.sequence.strategy);
  ++session.changes;
}

void set_recording(LiveSession& session, bool on) {
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

std::vector<RunSetting> settings_of(LiveSession& session) {
  std::vector<RunSetting> all;
  const CameraControls* const camera = session.recorder.controls();
  for (const auto& [which, name, help, unit] : camera_words) {
    const auto control = camera ? camera->control(which) : std::nullopt;
    if (control) all.push_back(number(name, help, unit, *control));
  }
  const EngineSetup setup = setup_of(session);
  const ReconstructSettings& settings = setup.settings;
  all.push_back({.name = "strategy",
                 .help = "what the projector shows",
                 .value = label_of(setup.sequence.strategy),
                 .choices = strategy_choices(session)});
  all.push_back(number("min-modulation", "least modulation of a point", "grey levels of 255",
                       {settings.minimum_modulation, 0, 127}));
  all.push_back(number("min-component", "fewest pixels of a connected piece", "pixels",
                       {static_cast<double>(settings.clean.smallest_component), 0, 1e6}));
  all.push_back(off_or_on("keep-saturated", "pixels with a saturated frame become points",
                          !settings.drop_saturated));
  const auto recording = session.recorder.recording();
  all.push_back(off_or_on("record", "all frames, into a new file", recording.has_value()));
  if (recording) all.back().state = text_of(*recording);
  return all;
}

void change_setting(LiveSession& session, const std::string& name, const std::string& value) {
  require_settable(settings_of(session), name, value);
  const double number = number_in<double>(value).value_or(0);
  const auto control = std::find_if(camera_words.begin(), camera_words.end(),
                                    [&](const CameraWords& words) { return name == words.name; });
  if (control != camera_words.end()) {
    session.recorder.controls()->set_control(control->which, number);
    ++session.changes;
    return;
  }
  const std::lock_guard lock(session.mutex);
  if (name == "record") return set_recording(session, value == "on");
  EngineSetup setup = session.setup;
  if (name == "strategy") {
    const bool given = value == label_of(session.strategy);
    setup.sequence.strategy = given ? session.strategy : strategy_labelled(value);
  } else if (name == "min-modulation") {
    setup.settings.minimum_modulation = number;
  } else if (name == "min-component") {
    setup.settings.clean.smallest_component = static_cast<int>(number);
  } else if (name == "keep-saturated") {
    setup.settings.drop_saturated = value == "off";
  }
  change_locked(session, std::move(setup));
}

}  // namespace slipstream::app
