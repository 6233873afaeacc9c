#include "app/session_settings.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "app/live_session.h"
#include "base/numbers.h"
#include "io/file.h"
#include "io/file_names.h"
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

void set_recording(RecordedSource& source, const std::string& folder, bool on) {
  if (!on) return source.finish_recording();
  if (source.recording()) return;
  make_folder(folder);
  const NewFile file(path_named_by_time(folder, "recording", ".slip"));
  source.record_to(file.path());
}

}  // namespace

std::vector<std::string> strategy_labels(const Strategy& strategy) {
  std::vector<std::string> labels;
  for (const Strategy& choice : strategies_beside(strategy)) labels.push_back(label_of(choice));
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

EngineSetup LiveSession::setup() const {
  const std::lock_guard lock(mutex_);
  return setup_;
}

void LiveSession::change(const EngineSetup& setup) {
  const std::lock_guard lock(mutex_);
  change_locked(setup);
}

void LiveSession::change_locked(EngineSetup setup) {
  if (motion_when_seen_) setup.sequence.motion = takes_motion(setup.sequence) ? 2 : 0;
  pipeline_->change(setup);
  setup_ = setup;
  source_->set_strategy(setup.sequence.strategy);
  ++changes_;
}

std::vector<RunSetting> LiveSession::settings() const {
  std::vector<RunSetting> all;
  const CameraControls* const camera = source_->controls();
  for (const auto& [which, name, help, unit, shown_as] : camera_controls) {
    const auto control = camera ? camera->control(which) : std::nullopt;
    if (control) all.push_back(number(name, help, unit, *control));
  }

  const EngineSetup now = setup();
  all.push_back({.name = "strategy",
                 .help = "patterns shown by the projector",
                 .value = label_of(now.sequence.strategy),
                 .choices = patterns_can_change_ ? strategy_labels(strategy_)
                                                 : std::vector{label_of(strategy_)}});
  for (RunSetting& setting : live_settings_of(now.settings)) all.push_back(std::move(setting));

  const auto recording = source_->recording();
  all.push_back(off_or_on("record", "record all frames into a new file", recording.has_value()));
  if (recording) all.back().state = text_of(*recording);

  if (rig_) {
    all.push_back(off_or_on("guard", "compare the rig with its calibration now", rig_->wants()));
    all.back().state = rig_->state();
  }
  return all;
}

void LiveSession::change(const std::string& setting, const std::string& value) {
  const std::string name = present_name(setting);
  require_settable(settings(), name, value);
  const auto control = std::ranges::find(camera_controls, name, &CameraControlWords::name);

  // 1. A control of the camera.
  if (control != camera_controls.end()) {
    source_->controls()->set_control(control->which, number_in<double>(value).value_or(0));
    ++changes_;
    return;
  }

  // 2. A guard, and recording on or off.
  if (name == "guard") return rig_->want(value == "on");

  const std::lock_guard lock(mutex_);
  if (name == "record") return set_recording(*source_, flags_.view.save_to, value == "on");

  // 3. A setting of the reconstruction, or the strategy.
  EngineSetup setup = setup_;
  if (name == "strategy") {
    const bool is_first = value == label_of(strategy_);
    setup.sequence.strategy = is_first ? strategy_ : strategy_labelled(value);
  }
  change_described(setup.settings, name, value);
  change_locked(std::move(setup));
}

}  // namespace slipstream::app
