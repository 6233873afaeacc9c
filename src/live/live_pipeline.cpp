#include "slipstream/live_pipeline.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <numeric>

#include <fmt/format.h>

#include "base/printable.h"
#include "base/throw_if-inl.h"
#include "live/change_signal.h"
#include "live/cloud_follower.h"
#include "live/live_run-inl.h"

namespace slipstream {
namespace {

/// Limit for the frames of a run, bytes: a few hundred frames of 20 MP and 16 bits.
constexpr std::uint64_t largest_run = std::uint64_t{16} << 30;

/// Clouds: one in each stage and queue, the newest, and those held by consumers and followers.
std::size_t clouds_needed(const LiveSettings& settings) {
  const std::size_t followers = (settings.track ? 1U : 0U) + (settings.model ? 1U : 0U);
  return 3 + 2 * stage_places + 1 + settings.held_clouds + followers * followed_clouds;
}

/// Frames: each cloud keeps its window; windows and index checks keep three cycles with markers;
/// one frame is being filled and one passed on.
std::size_t frames_needed(const LiveSettings& settings, const Sequence& sequence) {
  const auto window = static_cast<std::size_t>(frame_count(sequence));
  return clouds_needed(settings) * window + 3 * (window + 1) + settings.waiting_frames + 2;
}

std::string text_of_cleaned(const ValidityCounts& cleaned) {
  const std::size_t points = cleaned[static_cast<std::size_t>(Validity::valid)];
  std::string text = points == 0 ? "" : fmt::format("\nnewest cloud: {} points", points);

  std::string removed;
  for (std::size_t i = 1; i < validity_count; ++i) {
    if (cleaned[i] == 0) continue;
    removed += fmt::format("{}{}: {}", removed.empty() ? "\nremoved from the newest cloud, " : ", ",
                           name_of(static_cast<Validity>(i)), cleaned[i]);
  }

  return text + removed;
}

}  // namespace

LivePipeline::LivePipeline(std::unique_ptr<FrameSource> source, const EngineSetup& setup,
                           const LiveSettings& settings)
    : source_(std::move(source)),
      format_(source_->format()),
      settings_(settings),
      changes_(std::make_shared<ChangeSignal>()) {
  require_valid(format_);

  plan_ = plan_for(setup);

  // Reconstruct black frames once, so that each cloud has its memory before the first frame.
  const auto count = static_cast<std::size_t>(frame_count(setup.sequence));
  const std::vector<Pooled<Frame>> black(count, frames_->take());

  const auto make_cloud = [&] {
    LiveCloud cloud;
    cloud.frames = black;
    plan_->reconstruct(cloud);
    cloud.frames.clear();
    return cloud;
  };
  clouds_ = std::make_shared<Pool<LiveCloud>>(clouds_needed(settings), make_cloud,
                                              [changes = changes_] { changes->announce(); });
}

std::shared_ptr<WindowEngine> LivePipeline::plan_for(const EngineSetup& setup) {
  const Size camera = setup.scanner.camera.size;
  throw_if(camera != format_.size, "frames are {}, the scanner's camera has {}; both must agree",
           text_of(format_.size), text_of(camera));

  auto plan = std::make_shared<WindowEngine>(setup, settings_);

  // A setup that needs more frames gets a new pool; otherwise the present one is kept.
  const std::size_t needed = frames_needed(settings_, setup.sequence);
  throw_if(needed > largest_run / byte_count(format_),
           "a run needs {} frames of {} pixels; the limit is {} bytes", needed, text_of(camera),
           largest_run);
  if (needed > frame_count_) {
    frames_ = std::make_shared<Pool<Frame>>(
        needed, [this] { return Frame(format_); }, [changes = changes_] { changes->announce(); });
    frame_count_ = needed;
  }

  plan->frames = frames_;
  return plan;
}

std::shared_ptr<LiveRun> LivePipeline::run() const {
  const std::lock_guard lock(mutex_);
  return run_;
}

void LivePipeline::start() {
  stop();
  source_->start();
  auto begun = std::make_shared<LiveRun>(*source_, settings_, changes_, clouds_, plan_);
  const std::lock_guard lock(mutex_);
  run_ = std::move(begun);
  started_ = true;
}

void LivePipeline::stop() {
  if (!std::exchange(started_, false)) return;
  run()->stop();
  source_->stop();
}

template <class Answer>
Answer LivePipeline::answer_of(Answer (LiveRun::*question)() const) const {
  const auto current = run();
  return current ? (*current.*question)() : Answer();
}

bool LivePipeline::running() const {
  return answer_of(&LiveRun::capturing);
}

void LivePipeline::wait() const {
  if (const std::shared_ptr<LiveRun> now = run(); now) now->wait();
}

std::exception_ptr LivePipeline::failure() const {
  return answer_of(&LiveRun::failure);
}

void LivePipeline::change(const EngineSetup& setup) {
  plan_ = plan_for(setup);
  if (const auto current = run()) current->change(plan_);
}

Pooled<LiveCloud> LivePipeline::newest() const {
  return answer_of(&LiveRun::newest);
}

void LivePipeline::shown(std::chrono::steady_clock::time_point captured) {
  if (const auto current = run()) current->shown(captured);
}

LiveStatistics LivePipeline::statistics() const {
  return answer_of(&LiveRun::statistics);
}

ModelPoints LivePipeline::model() const {
  return answer_of(&LiveRun::model);
}

std::vector<LiveFinding> LivePipeline::findings() const {
  return answer_of(&LiveRun::findings);
}

std::string text_of(const LiveStatistics& statistics) {
  const LiveStatistics::Frames& frames = statistics.frames;
  std::string text = fmt::format(
      "{} frames in {:.1f} s: {} lost, {} overwritten, {} repeated\n"
      "{}, {:.1f} per second{}; {} windows lost, {} skipped, {} "
      "resynchronisations\n"
      "capture to cloud: median {:.2f} ms, 99 % below {:.2f} ms, maximum {:.2f} ms{}",
      frames.captured, statistics.seconds, frames.lost, frames.overwritten, frames.repeated,
      counted(statistics.clouds, "cloud"), statistics.clouds_per_second,
      statistics.backend.empty() ? "" : ", backend " + statistics.backend, statistics.windows_lost,
      statistics.windows_skipped, statistics.resynchronisations, statistics.latency.p50,
      statistics.latency.p99, statistics.latency.max, text_of_cleaned(statistics.cleaned));

  if (statistics.track) text += fmt::format("\n{}", text_of(*statistics.track));
  if (statistics.model) text += fmt::format("\n{}", text_of(*statistics.model));

  return text;
}

}  // namespace slipstream
