#include "app/rig_guard.h"

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "app/scan_flags.h"
#include "app/source_flags.h"
#include "codes/guard_sequence.h"
#include "frames/scan_camera.h"
#include "slipstream/error.h"

namespace slipstream::app {
namespace {

constexpr const char* no_guard =
    "no guard, as the scene did not stand still: a moved camera or projector would not show";
constexpr const char* frames_do_not_fit =
    "no guard: the frames of its scan do not fit their patterns";

/// One cycle of the patterns, without what belongs to a run.
Sequence scan_of(Sequence sequence) {
  sequence.motion = 0;
  return sequence;
}

/// Compares the frames of a cycle with its guard. Frames that do not fit their patterns do not show
/// the rig; the run itself reports them.
GuardResult compared(GuardedCycle taken, const EngineSetup& setup) {
  Scan scan{.frames = std::move(taken.cycle),
            .sequence = scan_of(setup.sequence),
            .scanner = setup.scanner};
  scan = merged(std::move(scan));
  if (any_wrong(check_and_repair(scan).findings)) return {};

  scan.guard.push_back(
      merged({.frames = std::move(taken.guard), .sequence = guard_sequence(scan.sequence)}));
  return compare_with_guard(scan, setup.settings);
}

}  // namespace

GuardResult compared_with_guard(const Scan& scan, const ReconstructSettings& settings,
                                Output& output) {
  try {
    GuardResult result = compare_with_guard(scan, settings);
    if (result.epipolar) tell_guard(*result.epipolar, "", output);
    return result;
  } catch (const Error& error) {
    output.warn(fmt::format("the guard is not compared: {}", error.what()));
    return {};
  }
}

std::vector<Image<std::uint8_t>> guard_pictures(const EngineSetup& setup,
                                                const NamedSource& opened) {
  const Sequence scan = scan_of(setup.sequence);
  const bool is_possible = has_geometry(setup.scanner) && !opened.in_colour && !scan.marker &&
                           can_be_guarded(scan) && has_coordinate(scan.strategy);
  if (!is_possible) return {};
  return pictures_to_show(guard_sequence(scan));
}

void RigWatch::look(const EngineSetup& setup) {
  using std::chrono::seconds;

  // 1. The result of a comparison.
  if (comparing_.valid()) {
    if (comparing_.wait_for(seconds(0)) != std::future_status::ready) return;
    try {
      tell(comparing_.get());
    } catch (const Error& error) {
      set_state(fmt::format("the guard is not compared: {}", error.what()));
      output_.warn(state());
    }
  }

  // 2. A guard that has come.
  std::optional<GuardedCycle> taken = source_.take_guard();
  if (!taken) return;
  if (taken->cycle.size() == Size{}) {
    set_state(no_guard);
    return output_.say("{}", no_guard);
  }

  comparing_ = std::async(std::launch::async, [frames = *std::move(taken), setup]() mutable {
    return compared(std::move(frames), setup);
  });
}

void RigWatch::finish(const EngineSetup& setup) {
  look(setup);
  while (comparing_.valid()) {
    comparing_.wait();
    look(setup);
  }
  if (state().empty()) output_.say("no guard has been compared in this run");
}

std::string RigWatch::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void RigWatch::set_state(std::string state) {
  const std::lock_guard lock(mutex_);
  state_ = std::move(state);
}

void RigWatch::tell(const GuardResult& result) {
  output_.document["guard"] = as_json(result.epipolar);
  if (result.epipolar) tell_guard(*result.epipolar, "", output_);

  set_state(result.epipolar ? "the rig stands as calibrated" : frames_do_not_fit);
  if (!result.epipolar && result.findings.empty()) output_.say("{}", frames_do_not_fit);
  for (const Finding& finding : result.findings) {
    set_state(with_flags(text_of(finding)));
    output_.warn(state());
  }
}

}  // namespace slipstream::app
