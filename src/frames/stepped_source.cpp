#include "frames/stepped_source.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <variant>
#include <vector>

#include "frames/scan_camera.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr int flashes = 12;
/// No projector and camera are slower together.
constexpr milliseconds slowest{3000};

/// After as long without a frame the rig may have been touched.
constexpr std::chrono::seconds long_pause{5};
/// Attempts at a guard, in a scene that does not stand still.
constexpr int most_tries = 4;
/// A guard ends after as many pictures, times its patterns, even if some have no frame alone.
constexpr std::size_t most_shown = 4;

/// Mean grey level, of 255.
double mean_level(const Frame& frame) {
  return std::visit(
      [&](const auto& image) {
        const double sum = std::accumulate(image.begin(), image.end(), 0.0);
        return sum / static_cast<double>(image.pixel_count()) * 255 / ((1 << frame.bits) - 1);
      },
      frame.pixels);
}

/// Whether each pattern has a frame.
bool are_whole(const std::vector<std::optional<Frame>>& taken) {
  return std::ranges::all_of(taken, [](const auto& frame) { return frame.has_value(); });
}

/// The frames of patterns that all have one.
std::vector<Frame> frames_of(std::vector<std::optional<Frame>> taken) {
  std::vector<Frame> frames;
  for (std::optional<Frame>& frame : taken) frames.push_back(*std::move(frame));
  return frames;
}

}  // namespace

SteppedSource::SteppedSource(PatternSink& sink, std::unique_ptr<FrameSource> camera,
                             const std::vector<Image<std::uint8_t>>& patterns, bool triggered,
                             const std::vector<Image<std::uint8_t>>& guard)
    : SourceOver(std::move(camera)),
      sink_(sink),
      patterns_(patterns),
      cycle_(patterns.size()),
      guard_(guard.size()),
      triggered_(triggered),
      frame_(source_->format()) {
  patterns_.insert(patterns_.end(), guard.begin(), guard.end());
  require_patterns(patterns_, sink.size(), "the projector");
}

void SteppedSource::start() {
  stop();

  // A failure before the stop, and the patterns shown then, are over.
  came_.reset();
  {
    const std::lock_guard lock(mutex_);
    failure_ = nullptr;
    shown_.clear();
  }

  // A guard that was begun before the stop starts over.
  want_guard(false);
  want_guard(true);

  source_->start();
  if (delay_.ends == nanoseconds{}) measure_delay();
  sink_.load(patterns_);
  if (!triggered_) thread_ = std::thread([this] { run(); });
}

void SteppedSource::stop() {
  is_ending_ = true;
  if (thread_.joinable()) thread_.join();
  is_ending_ = false;
  source_->stop();
}

SourceCounters SteppedSource::counters() const {
  SourceCounters counters = source_->counters();
  counters.delivered = taken_;
  counters.lost += missed_;
  return counters;
}

SteppedSource::Clock::time_point SteppedSource::arrival_of(const Frame& frame) {
  constexpr nanoseconds restarted = std::chrono::seconds(1);
  constexpr int frames_of_drift = 10'000;  // clocks drift by at most one frame in this many

  const auto host = frame.stamp.host_time.time_since_epoch();
  const nanoseconds device = frame.stamp.device_time;

  if (device == nanoseconds{}) return frame.stamp.host_time;

  // Delays of this machine only add to the offset: keep the least, but let it follow the drift of
  // the clocks. A device that restarts its clock starts a new offset.
  const nanoseconds offset = host - device;
  const nanoseconds drifted = clock_offset_ + delay_.period / frames_of_drift;
  clock_offset_ = offset > drifted && offset < drifted + restarted ? drifted : offset;

  return Clock::time_point(device + clock_offset_);
}

std::optional<SteppedSource::Clock::time_point> SteppedSource::take(Frame& frame,
                                                                    milliseconds timeout) {
  const Clock::time_point begin = Clock::now();
  if (triggered_) source_->trigger();

  do {
    const Arrival arrival = source_->next(frame, std::min(timeout, milliseconds(100)));
    if (arrival == Arrival::ended) throw WorldError("the source of frames has ended");
    if (arrival == Arrival::frame) return triggered_ ? begin : arrival_of(frame);
  } while (Clock::now() < begin + timeout);

  return std::nullopt;
}

void SteppedSource::flash(std::size_t pattern) {
  // Frames differ by noise; a change of light by more.
  constexpr double alike = 0.02, least_change = 4;
  constexpr std::size_t settled = 3;  // frames

  const double before = light_;
  sink_.show(pattern);
  const Clock::time_point shown = Clock::now();
  std::vector<std::pair<nanoseconds, double>> frames;

  // 1. Frames until the light has changed and stays the same.
  const auto is_settled = [&] {
    if (frames.size() < settled) return false;
    const auto [least, most] =
        std::minmax_element(frames.end() - static_cast<int>(settled), frames.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; });

    light_ = most->second;
    return most->second - least->second <= alike * change_ &&
           std::abs(light_ - before) > std::max(least_change, change_ / 2);
  };

  while (!is_settled()) {
    const auto time = take(frame_, slowest);
    if (!time || *time > shown + slowest) {
      throw WorldError(
          "the camera does not see the projector: black and white look the same to it; check "
          "exposure, lens and monitor");
    }

    frames.emplace_back(*time - shown, mean_level(frame_));
  }

  // 2. The first frame with new light and the last with old light bound the delay.
  change_ = std::abs(light_ - before);
  for (const auto& [time, level] : frames) {
    if (std::abs(level - before) < alike * change_) continue;

    delay_.begins = std::min(delay_.begins, time);
    if (std::abs(level - light_) > alike * change_) delay_.ends = std::max(delay_.ends, time);
  }

  delay_.period =
      (frames.back().first - frames.front().first) / static_cast<int>(frames.size() - 1);
}

void SteppedSource::measure_delay() {
  // 1. Black and the brightest level of the patterns.
  std::uint8_t brightest = 0;
  for (const auto& pattern : patterns_) {
    brightest = std::max(brightest, *std::max_element(pattern.begin(), pattern.end()));
  }

  const Size size = patterns_.front().size();
  sink_.load({Image<std::uint8_t>(size, 0), Image<std::uint8_t>(size, brightest)});

  // 2. The level in black, after all older frames.
  sink_.show(0);
  std::this_thread::sleep_for(milliseconds(500));
  while (source_->next(frame_, milliseconds(1)) == Arrival::frame) continue;
  if (!take(frame_, slowest)) throw WorldError("no frame from the camera within 3 s");
  light_ = mean_level(frame_);

  // 3. Flashes at times spread over the camera's period.
  delay_ = {.begins = slowest};
  for (int i = 0; i < flashes; ++i) {
    std::this_thread::sleep_for(i * delay_.period / flashes);  // anywhere between two frames
    flash(i % 2 == 0 ? 1U : 0U);
  }

  // A flash may have missed a bound by as much.
  const nanoseconds margin = 2 * delay_.period / flashes;
  delay_.begins -= margin;
  delay_.ends = std::max(delay_.ends, delay_.begins) + margin;
}

bool SteppedSource::wants_guard() const {
  const std::lock_guard lock(guard_mutex_);
  return wanted_.has_value();
}

void SteppedSource::want_guard(bool wanted) {
  const std::lock_guard lock(guard_mutex_);
  if (!wanted) {
    wanted_.reset();
  } else if (has_guard() && !wanted_) {
    plan_guard(1);
  }
}

std::optional<GuardedCycle> SteppedSource::take_guard() {
  const std::lock_guard lock(guard_mutex_);
  return std::exchange(guarded_, std::nullopt);
}

void SteppedSource::plan_guard(int tries) {
  wanted_ = WantedGuard{
      .before = Taken(cycle_), .guard = Taken(guard_), .after = Taken(cycle_), .tries = tries};
}

std::optional<std::size_t> SteppedSource::next_of_guard() {
  const std::lock_guard lock(guard_mutex_);
  if (!wanted_) return std::nullopt;
  WantedGuard& wanted = *wanted_;

  // 1. It begins between two cycles, once each pattern of one has a frame.
  if (!wanted.followed_by) {
    if (next_ % cycle_ != 0 || !are_whole(wanted.before)) return std::nullopt;
    wanted.followed_by = next_;
  }

  // 2. One pattern after the other, and again those without a frame.
  if (next_ != *wanted.followed_by || wanted.shown >= most_shown * guard_) return std::nullopt;
  for (std::size_t skipped = 0; skipped < guard_; ++skipped) {
    const std::size_t pattern = (wanted.shown + skipped) % guard_;
    if (wanted.guard[pattern]) continue;
    wanted.shown += skipped + 1;
    return pattern;
  }
  return std::nullopt;
}

void SteppedSource::keep_for_guard(const Frame& frame, const Shown& shown) {
  std::optional<WantedGuard> done;
  {
    const std::lock_guard lock(guard_mutex_);
    if (!wanted_) return;
    WantedGuard& wanted = *wanted_;
    const bool has_begun = wanted.followed_by.has_value();

    if (shown.in_guard) {
      // Not one of a guard that was cancelled.
      if (has_begun) wanted.guard[shown.sequence] = frame;
      return;
    }

    const bool is_after = has_begun && shown.sequence >= *wanted.followed_by;
    (is_after ? wanted.after : wanted.before)[shown.sequence % cycle_] = frame;
    if (are_whole(wanted.after)) done = std::exchange(wanted_, std::nullopt);
  }
  if (done) end_guard(*std::move(done));
}

void SteppedSource::end_guard(WantedGuard done) {
  std::optional<GuardedCycle> guarded;

  // Whatever moved between the cycle and its guard would look like a rig that has moved.
  if (are_whole(done.guard)) {
    FrameSet before = frame_set_of(frames_of(std::move(done.before)));
    if (is_still(before, frame_set_of(frames_of(std::move(done.after))))) {
      guarded = {.cycle = std::move(before),
                 .guard = frame_set_of(frames_of(std::move(done.guard)))};
    }
  }

  const std::lock_guard lock(guard_mutex_);
  if (guarded || done.tries == most_tries) {
    guarded_ = guarded ? std::move(guarded) : GuardedCycle();
  } else if (!wanted_) {
    plan_guard(done.tries + 1);
  }
}

void SteppedSource::show_next() {
  const std::lock_guard lock(mutex_);  // also until it is known when

  if (const std::optional<std::size_t> of_guard = next_of_guard()) {
    sink_.show(cycle_ + *of_guard);
    shown_.push_back({*of_guard, true, Clock::now()});
    return;
  }

  sink_.show(next_ % cycle_);
  shown_.push_back({next_++, false, Clock::now()});
}

void SteppedSource::run() try {
  while (!is_ending_) {
    show_next();
    std::this_thread::sleep_for(hold());
  }
} catch (...) {
  const std::lock_guard lock(mutex_);
  failure_ = std::current_exception();
}

std::optional<SteppedSource::Shown> SteppedSource::shown_alone(Clock::time_point time) {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);

  // Patterns that were replaced before this frame began to see the next are missed.
  while (shown_.size() > 1 && shown_[1].time + delay_.begins <= time) {
    if (!shown_.front().in_guard) ++missed_;
    shown_.pop_front();
  }

  // The frame shows one pattern alone once all light of the one before is gone.
  if (shown_.empty() || shown_.front().time + delay_.ends > time) return std::nullopt;
  const Shown shown = shown_.front();
  shown_.pop_front();
  return shown;
}

Arrival SteppedSource::next(Frame& frame, milliseconds timeout) {
  if (triggered_) {
    show_next();
    std::this_thread::sleep_for(delay_.ends);
  }

  const Clock::time_point end = Clock::now() + timeout;
  while (const auto time = take(frame, std::max(milliseconds(1), timeout))) {
    if (const std::optional<Shown> shown = shown_alone(*time)) {
      keep_for_guard(frame, *shown);
      const auto before = std::exchange(came_, *time);
      if (before && *time > *before + long_pause) want_guard(true);
      if (shown->in_guard) return Arrival::nothing;

      frame.stamp.sequence = shown->sequence;
      frame.stamp.pattern_index = static_cast<int>(shown->sequence % cycle_);
      ++taken_;
      return Arrival::frame;
    }

    if (Clock::now() > end) break;
  }

  return Arrival::nothing;
}

}  // namespace slipstream
