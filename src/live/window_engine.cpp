#include "live/window_engine.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/throw_if-inl.h"
#include "decode/frame_adapter.h"
#include "frames/copied_frames.h"
#include "frames/pattern_windows.h"
#include "merge/fused_model.h"
#include "reconstruct/camera_pair.h"
#include "scan_job/fused_cameras.h"

namespace slipstream {
namespace {

/// So few samples cost almost nothing compared with a cycle's clouds.
constexpr ScanSamples::Effort few{
    .most_looked = 384, .fewest_looked = 48, .lit_wanted = 32, .all_places = false};

/// Interval of full checks while a problem lasts, as the problem may change.
constexpr std::chrono::milliseconds next_look{500};

/// Share of moving pixels from which a window counts as moving.
constexpr double least_moving = 0.01;

/// Replaces advice that a live run cannot follow: it takes no order of frames.
std::vector<Finding> with_live_advice(std::vector<Finding> findings) {
  const auto sets_order = [](const Remedy& remedy) {
    return std::ranges::any_of(
        remedy.settings, [](const SettingChange& setting) { return setting.name == "order"; });
  };

  for (Finding& finding : findings) {
    if (blames(finding, CauseKind::frame_order)) {
      finding.remedies = {{"show the patterns in the order of the strategy"}};
      finding.remark.clear();
    }
    std::erase_if(finding.remedies, sets_order);
  }

  return findings;
}

/// LiveCheck as a copyable function.
std::function<std::vector<Finding>(const FrameViews&)> live_check(const EngineSetup& setup) {
  const bool known = has_geometry(setup.scanner);

  const auto check = std::make_shared<LiveCheck>(
      merged_sequence(setup.sequence), known ? std::optional(setup.scanner) : std::nullopt,
      setup.scanner.camera.size,
      CheckSettings{.minimum_modulation = setup.settings.minimum_modulation,
                    .moving = true,
                    .photometry = setup.scanner.photometry});

  return [check](const FrameViews& window) { return check->look(window); };
}

}  // namespace

LiveCheck::LiveCheck(const Sequence& sequence, const std::optional<Scanner>& scanner, Size camera,
                     const CheckSettings& settings)
    : sequence_(sequence),
      scanner_(scanner),
      settings_(settings),
      model_(sequence, scanner ? scanner->photometry : settings.photometry),
      order_(model_.identity()),
      judge_(model_),
      samples_(camera, frame_count(sequence.strategy)) {}

LiveCheck::Suspicion LiveCheck::suspicion(const FrameViews& window) {
  ScanSamples::Effort effort = few;
  effort.least_range = least_range(settings_);
  samples_.take(window, effort);

  // A frame that is 5 % brighter leaves a residual of 0.012 and more.
  constexpr double most_residual = 0.011;

  fit_.moving = settings_.moving;
  fit_.frames = judge_(samples_, order_);

  Suspicion raised;
  raised[0] = fit_.frames.residual > std::max(most_residual, harmless_residual_);
  raised[1] = !fit_.bands_agree();
  raised[2] = !fit_.no_seam();

  // Something covers the projector or the camera, for example.
  constexpr double least_light = 0.5;  // of a frame's light since the last good check
  for (std::size_t n = 0; n < right_sums_.size(); ++n) {
    if (samples_.sums()[n] < least_light * right_sums_[n]) raised[3] = true;
  }

  return raised;
}

std::vector<Finding> LiveCheck::look(const FrameViews& window) {
  // 1. Sample a few pixels; brightness that raises no suspicion becomes the new reference.
  const bool first = checked_ == Clock::time_point{};
  const Suspicion raised = suspicion(window);
  if (!raised.any()) right_sums_.assign(samples_.sums().begin(), samples_.sums().end());

  // 2. Decide whether the full check is needed: to see if a known problem changed, or because of
  // a suspicion that was not cleared before. The first frames always get it.
  const Clock::time_point now = Clock::now();
  if (!findings_.empty()) {
    if (suspected_.any() && !raised.any()) {
      findings_.clear();  // the problem is gone
      return {};
    }
    if (raised == suspected_ && now - checked_ < next_look) return findings_;
  } else {
    harmless_ &= raised;
    if (!first && harmless_ == raised) return {};
  }

  // 3. Run the full check.
  findings_ = check_frames(window, sequence_, scanner_, settings_).findings;
  checked_ = now;
  suspected_ = raised;
  // A suspicion that the full check clears, such as motion, does not start it again.
  if (findings_.empty()) {
    harmless_ = raised;
    // A margin of 30 %, since the residual varies from window to window.
    harmless_residual_ = 1.3 * fit_.frames.residual;
  }
  return findings_;
}

namespace {

/// Setup for the frames of one camera of a pair: phases along one axis, no points.
EngineSetup of_one_camera(EngineSetup setup) {
  setup.sequence = along(setup.sequence, setup.sequence.axis);
  setup.scanner = without_geometry(setup.scanner.camera.size, setup.scanner.projector.size,
                                   setup.scanner.photometry);
  return setup;
}

}  // namespace

WindowEngine::WindowEngine(const EngineSetup& setup, const LiveSettings& settings)
    : whole(setup),
      sequence(std::make_shared<const Sequence>(setup.sequence)),
      check(settings.check),
      colour(settings.colour) {
  const bool paired = settings.second_camera.has_value();
  engines.emplace_back(paired ? of_one_camera(setup) : setup);
  if (!check) check = live_check(engines.front().setup());

  // The pair is matched by one PhaseMatcher, or fused as a finished scan; its first camera's engine
  // serves the checks.
  if (paired && settings.fuse) {
    throw_if(setup.sequence.motion > 0,
             "two cameras are fused live from the frames of one cycle; set `motion 0`");
    require_pair(setup.scanner, *settings.second_camera, {});
    fuse.emplace(
        ScanJobSettings{.reconstruct = setup.settings, .keep_refused = true, .fuse = true});
    second = settings.second_camera;
    return;
  }
  if (paired) {
    require_matchable(setup.settings);
    match.emplace(setup.scanner, *settings.second_camera, setup.sequence, setup.settings);
    return;
  }

  // With motion frames, a window may begin with any pattern: one engine for each first pattern.
  EngineSetup later = setup;
  const int starts = setup.sequence.motion > 0 ? cycle_length(setup.sequence) : 1;
  for (int first = 1; first < starts; ++first) {
    later.sequence = merged_sequence(setup.sequence, first);
    engines.emplace_back(later);
  }

  if (settings.motion_when_seen && setup.sequence.motion > 0) {
    later.sequence = cycle_of(setup.sequence);
    still.emplace(later);
  }
}

ValidityCounts WindowEngine::reconstruct(LiveCloud& window) {
  const ValidityCounts removed = reconstruct_points(window);
  if (window.cloud.z.size() == colour.size()) window.cloud.colour = colour;
  return removed;
}

ValidityCounts WindowEngine::reconstruct_points(LiveCloud& window) {
  if (match) return match_cameras(window);
  if (fuse) return fuse_cameras(window);

  used = &engines[static_cast<std::size_t>(window.first_pattern)];

  // Points need a scanner.
  if (!has_geometry(setup().scanner)) {
    if (!window.cloud.z.empty()) window.cloud = Cloud();
    return {};
  }
  view_window(window.frames, views);

  // While nothing moves, the middle cycle alone is enough.
  const int extra = setup().sequence.motion;
  if (still && used->moving_share(views) < least_moving) {
    used = &*still;
    window.motion = 0;
    return still->cloud(middle_cycle(views, window.first_pattern, extra), window.cloud);
  }

  window.motion = extra;
  return used->cloud(views, window.cloud);
}

ValidityCounts WindowEngine::match_cameras(LiveCloud& window) {
  used = &engines.front();
  view_window(window.frames, views);
  view_second(window.frames, second_views);

  if (second_views.size().width == 0) {  // no picture has come yet
    window.cloud = Cloud(views.size());
    return {};
  }

  // The matcher writes into its result: lend it the window's cloud, so that memory is reused.
  std::swap(window.cloud, matched.cloud);
  match->run(views, second_views, matched, window.first_pattern);
  std::swap(window.cloud, matched.cloud);

  window.motion = whole.sequence.motion;
  return matched.cleaned;
}

ValidityCounts WindowEngine::fuse_cameras(LiveCloud& window) {
  used = &engines.front();
  view_window(window.frames, views);
  view_second(window.frames, second_views);
  window.fused.reset();
  window.fused_points = Cloud();
  window.cloud = Cloud(views.size());
  of_pair.clear();
  if (second_views.size().width == 0) return {};  // no picture has come yet

  // 1. The window as a scan.
  const auto scan_of = [&](const FrameViews& frames, const Scanner& scanner) {
    return merged({.frames = copied(frames), .sequence = whole.sequence, .scanner = scanner});
  };
  Scan scan = scan_of(views, whole.scanner);
  scan.further_cameras.push_back(scan_of(second_views, *second));

  // 2. Its points; a camera that is covered for a while does not end the run.
  const std::string name = "window";
  try {
    const CheckedJob job = checked_job(std::move(scan), fuse->settings(), name);
    of_pair = job.checked.findings;

    ScanResult result = (*fuse)(job, name);
    window.fused = result.fused;
    window.fused_points = model_points(*result.fused).cloud;
    window.cloud = std::move(result.cloud);

    // The live statistics count what cleaning removed: the kinds of validity from low trust on.
    std::fill_n(result.counts.begin(), static_cast<int>(Validity::low_trust), 0);

    // Few points are usual in a live scene.
    of_pair = std::move(result.checked.findings);
    std::erase_if(of_pair,
                  [](const Finding& finding) { return finding.kind == FindingKind::few_points; });
    return result.counts;
  } catch (const Error& error) {
    // The error begins with the name of its scan, which means nothing to the reader here.
    std::string what = error.what();
    if (what.starts_with(name + ": ")) what.erase(0, name.size() + 2);
    of_pair.push_back({.kind = FindingKind::few_points, .what = std::move(what)});
    return {};
  }
}

bool WindowEngine::is_due(const LiveCloud& window) const {
  const std::uint64_t newest = window.newest.sequence, cycle = window.frames.size();
  if (window.first_pattern != 0) return false;   // the check takes frames in pattern order
  if (!looked || newest < *looked) return true;  // the first, or the source restarted its count

  // With lost frames, the window that ends a cycle may never come: use another one.
  const bool ends_cycle = window.frames.back()->stamp.sequence == newest;
  // Half a cycle of patience before a window that ends elsewhere will do.
  return newest - *looked >= (ends_cycle ? cycle : cycle + cycle / 2);
}

std::vector<Finding> WindowEngine::look(const LiveCloud& window) {
  looked = window.newest.sequence;
  view_window(window.frames, views);
  if (fuse) return with_live_advice(of_pair);
  if (!match) return with_live_advice(check(engines.front().merged(views)));

  // Check the first camera by itself, then the agreement between both cameras.
  const int count = frame_count(engines.front().setup().sequence);
  std::vector<Finding> findings = check(engines.front().merged(views.part(0, count)));

  if (matched.agreement && matched.agreement->phase_shift != 0)
    findings.push_back(wrong_origin(whole.sequence.strategy, matched.agreement->phase_shift));

  return with_live_advice(std::move(findings));
}

}  // namespace slipstream
