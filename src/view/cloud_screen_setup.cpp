#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "view/cloud_screen.h"

// How a screen changes settings of its source: of the scan, and of the camera.
namespace slipstream::view {
namespace {

/// The place of a value among labelled choices; several may have the same value. The present
/// place if it has the value, or if none has.
template <class Value>
std::size_t place_of(const Value& value, const std::vector<std::pair<std::string, Value>>& choices,
                     std::size_t present) {
  if (present < choices.size() && choices[present].second == value) return present;

  const auto found = std::ranges::find(choices, value, &std::pair<std::string, Value>::second);
  return found == choices.end() ? present : static_cast<std::size_t>(found - choices.begin());
}

}  // namespace

bool CloudScreen::change_setup() {
  // Build the engine first: it refuses an unsuitable setup before the source changes.
  const EngineSetup before = engine_->setup();
  const bool accepted = attempt([&] {
    Engine engine(state_.setup);
    source_.change(state_.setup);
    engine_ = std::move(engine);
  });

  // The panel keeps or takes back the choices.
  if (accepted) {
    earlier_.push_back(before);
    accepted_ = {state_.strategy, state_.gamma};
  } else {
    state_.setup = engine_->setup();
    std::tie(state_.strategy, state_.gamma) = accepted_;
  }

  return accepted;
}

void CloudScreen::undo() {
  if (earlier_.empty()) return;

  state_.setup = earlier_.back();
  choose_as_in(state_.setup);
  earlier_.pop_back();
  if (change_setup()) earlier_.pop_back();  // the state that was undone
}

void CloudScreen::hear_of_changes() {
  const auto setup = source_.changed ? source_.changed() : std::nullopt;
  if (!setup) return;

  ask_camera();
  if (!engine_ || *setup == state_.setup) return;

  engine_.emplace(*setup);
  state_.setup = *setup;
  earlier_.clear();
  choose_as_in(*setup);
  accepted_ = {state_.strategy, state_.gamma};
}

void CloudScreen::choose_as_in(const EngineSetup& setup) {
  state_.strategy = place_of(setup.sequence.strategy, source_.strategies, state_.strategy);
  state_.gamma = place_of(setup.scanner.photometry.response, source_.gammas, state_.gamma);
}

void CloudScreen::expose() {
  // Half a second after a change, so that the cloud was taken with the present exposure.
  const auto now = std::chrono::steady_clock::now();
  if (exposures_to_set_ == 0 || now < exposed_at_ + std::chrono::milliseconds(500)) return;

  --exposures_to_set_;
  const bool changed = attempt([&] {
    const ControlValue present = source_.camera->control(CameraControl::exposure).value();
    const double best =
        std::clamp(source_.best_exposure(cloud_, present.value), present.least, present.most);

    // Near enough to the best: set it, and stop.
    constexpr double alike = 1.05;
    if (best < alike * present.value && alike * best > present.value) exposures_to_set_ = 0;
    source_.camera->set_control(CameraControl::exposure, best);
  });

  if (!changed) exposures_to_set_ = 0;
  exposed_at_ = now;
  ask_camera();
}

void CloudScreen::ask_camera() {
  state_.camera.clear();
  if (source_.camera == nullptr) return;

  for (const auto& [which, name, help, unit, shown_as] : camera_controls) {
    if (const auto value = source_.camera->control(which)) state_.camera.push_back({which, *value});
  }
}

}  // namespace slipstream::view
