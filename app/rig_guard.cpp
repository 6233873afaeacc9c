#include "app/rig_guard.h"

#include <chrono>
#include <utility>
#include <vector>

#include "app/scan_flags.h"
#include "app/source_flags.h"
#include "codes/guard_sequence.h"
#include "frames/scan_camera.h"
#include "slipstream/error.h"

namespace slipstream::app {
namespace {

/// The frames of a scan and of its guard; empty if the scene does not stand still.
std::vector<FrameSet> taken_with_guard(const MonitorProjector& projector, bool triggered,
                                       FrameSource& camera, const Sequence& scan) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::seconds patience(4);
  constexpr std::chrono::milliseconds longest_look(200);

  ShownScans scans(*projector.sink, camera,
                   {pictures_to_show(scan), pictures_to_show(guard_sequence(scan))},
                   {.triggered = triggered});

  const Clock::time_point end = Clock::now() + patience;
  while (Clock::now() < end && !projector.closed()) {
    const std::optional<Glimpse> glimpse = scans.look(longest_look);
    if (!glimpse || !glimpse->still) continue;
    if (auto frames = scans.take()) return *std::move(frames);
  }
  return {};
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

void check_rig(const MonitorProjector& projector, bool triggered, const EngineSetup& setup,
               const NamedSource& opened, Output& output) {
  // 1. One cycle of the patterns, without what belongs to a run.
  Scan scan{.sequence = setup.sequence, .scanner = setup.scanner};
  scan.sequence.motion = 0;
  scan.sequence.marker = false;
  const bool is_possible = has_geometry(setup.scanner) && !opened.in_colour &&
                           can_be_guarded(scan.sequence) && has_coordinate(scan.sequence.strategy);
  if (!is_possible) return;

  // 2. The frames of the scan and of its guard.
  std::vector<FrameSet> taken;
  opened.frames->start();
  try {
    taken = taken_with_guard(projector, triggered, *opened.frames, scan.sequence);
  } catch (...) {
    opened.frames->stop();
    throw;
  }
  opened.frames->stop();

  if (taken.empty()) {
    output.say(
        "no guard, as the scene does not stand still: a camera or projector that moved since "
        "calibration would not show");
    return;
  }

  // 3. Frames that do not fit their patterns do not show the rig; the run itself reports them.
  scan.frames = std::move(taken.front());
  scan = merged(std::move(scan));
  if (any_wrong(check_and_repair(scan).findings)) return;
  scan.guard.push_back(
      merged({.frames = std::move(taken.back()), .sequence = guard_sequence(scan.sequence)}));

  const GuardResult result = compared_with_guard(scan, setup.settings, output);
  output.document["guard"] = as_json(result.epipolar);
  for (const Finding& finding : result.findings) output.warn(text_of(finding));
}

}  // namespace slipstream::app
