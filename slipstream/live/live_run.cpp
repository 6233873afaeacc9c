#include "slipstream/live/live_run.h"

#include <algorithm>
#include <utility>

#include "slipstream/decode/frame_adapter.h"
#include "slipstream/frames/thread_priority.h"
#include "slipstream/live/live_check.h"

namespace slipstream {
namespace {
using namespace std::chrono_literals;

/// How soon a stage notices that it is to stop, while the source is silent.
constexpr auto notice = 50ms;
/// How often a stage looks whether a consumer has given something back.
constexpr auto look_again = 200us;
/// How long clouds are waited for at the stop.
constexpr auto patience = 200ms;

bool same_patterns(const Sequence& a, const Sequence& b) {
  return a.strategy == b.strategy && a.axis == b.axis && a.exposures == b.exposures;
}

const Sequence& sequence_of(const LivePlan& plan) {
  return plan.reconstruct->engines.front().setup().sequence;
}

/// Share of the pixels that move from which on a window is no still one.
constexpr double least_moving = 0.01;

/// LiveCheck as a function that can be copied.
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

WindowEngine::WindowEngine(const EngineSetup& setup, const LiveSettings& settings)
    : engines{Engine(setup)}, check(settings.check ? settings.check : live_check(setup)) {
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
  used = &engines[static_cast<std::size_t>(window.first_pattern)];
  if (!has_geometry(engines.front().setup().scanner)) {
    if (!window.cloud.z.empty()) window.cloud = Cloud();
    return {};
  }
  view_window(window.frames, views);
  const int extra = engines.front().setup().sequence.motion;
  if (still && used->moving_share(views) < least_moving) {
    used = &*still;
    window.motion = 0;
    return still->cloud(middle_cycle(views, window.first_pattern, extra), window.cloud);
  }
  window.motion = extra;
  return used->cloud(views, window.cloud);
}

bool WindowEngine::is_due(const LiveCloud& window) const {
  const std::uint64_t newest = window.newest.sequence, cycle = window.frames.size();
  if (window.first_pattern != 0) return false;   // the check takes frames in pattern order
  if (!looked || newest < *looked) return true;  // the first, or the source counts anew
  // Where frames are lost the window that ends a cycle may never come: another has to do then.
  const bool ends_cycle = window.frames.back()->stamp.sequence == newest;
  return newest - *looked >= (ends_cycle ? cycle : cycle + cycle / 2);
}

std::vector<Finding> WindowEngine::look(const LiveCloud& window) {
  looked = window.newest.sequence;
  view_window(window.frames, views);
  return check(engines.front().merged(views));
}

LiveRun::LiveRun(FrameSource& source, const LiveSettings& settings,
                 std::shared_ptr<Pool<LiveCloud>> clouds, std::shared_ptr<const LivePlan> plan)
    : source_(source),
      settings_(settings),
      format_(source.format()),
      paced_(source.has_own_pace()),
      clouds_(std::move(clouds)),
      plan_(std::move(plan)),
      captured_(paced_ ? std::max<std::size_t>(settings.waiting_frames, 1) : stage_places),
      windows_(stage_places),
      finished_(stage_places),
      followed_(settings, plan_->reconstruct->engines.front().setup().scanner.camera,
                [this](std::exception_ptr failure) { fail(std::move(failure)); }) {
  try {
    threads_[0] = thread_of([this] { capture(); });
    threads_[1] = thread_of([this] { make_windows(); });
    threads_[2] = thread_of([this] { reconstruct(); });
    threads_[3] = thread_of([this] { show(); });
  } catch (...) {  // those that run are not left alone
    fail(std::current_exception());
    stop();
    throw;
  }
}

template <class Stage>
std::thread LiveRun::thread_of(Stage stage) {
  return std::thread([this, stage] {
    try {
      stage();
    } catch (...) {
      fail(std::current_exception());
    }
  });
}

void LiveRun::fail(std::exception_ptr failure) {
  {
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = std::move(failure);
  }
  stopping_ = true;
  capturing_ = false;
  captured_.close();
  windows_.close();
  finished_.close();
}

void LiveRun::stop() {
  stopping_ = true;
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
  followed_.finish();
  const std::lock_guard lock(mutex_);
  if (!end_) end_ = Clock::now();
}

void LiveRun::change(std::shared_ptr<const LivePlan> plan) {
  const std::lock_guard lock(mutex_);
  plan_ = std::move(plan);
}

void LiveRun::shown(Clock::time_point captured) {
  screen_latency_.add(Clock::now() - captured);
}

Pooled<Frame> LiveRun::free_frame() {
  const std::shared_ptr<Pool<Frame>> frames = locked(plan_)->frames;
  Pooled<Frame> frame = frames->take();
  if (paced_) {
    if (!frame && captured_.drop_oldest()) {
      ++frames_overwritten_;
      frame = frames->take();
    }
    return frame;
  }
  while (!frame && !stopping_) {
    std::this_thread::sleep_for(look_again);
    frame = frames->take();
  }
  return frame;
}

void LiveRun::receive(Pooled<Frame> frame) {
  const SequenceWatch::Kind kind = sequence_.look(frame->stamp.sequence);
  frames_lost_ = sequence_.lost();
  if (kind == SequenceWatch::Kind::repeated) {
    ++frames_repeated_;
    return;
  }
  ++frames_captured_;
  const Clock::time_point captured_at = frame->stamp.host_time;
  if (paced_) {
    if (captured_.push_over_oldest({std::move(frame), sequence_.restarts()})) ++frames_overwritten_;
  } else {
    captured_.push_when_room({std::move(frame), sequence_.restarts()});
  }
  capture_meter_.done(captured_at);
}

void LiveRun::capture() {
  if (paced_) go_when_woken();
  Frame nobodys(format_);  // what comes while every frame is held
  const auto enough = [this] {
    return settings_.most_frames && frames_captured_ >= *settings_.most_frames;
  };
  while (!stopping_ && !enough() && (paced_ || captured_.wait_for_room())) {
    Pooled<Frame> frame = free_frame();
    if (!frame && !paced_) break;
    Frame& filled = frame ? frame.fill() : nobodys;
    Arrival arrival = source_.next(filled, notice);
    if (arrival == Arrival::ended) break;
    if (arrival == Arrival::frame && filled.format() != format_) {
      filled = Frame(format_);
      arrival = Arrival::damaged;
    }
    if (arrival == Arrival::damaged) {
      sequence_.damaged();
      frames_lost_ = sequence_.lost();
    }
    if (arrival != Arrival::frame) continue;
    if (frame) {
      receive(std::move(frame));
    } else {
      sequence_.look(nobodys.stamp.sequence);
      ++frames_captured_;
      ++frames_overwritten_;
    }
  }
  capturing_ = false;
  captured_.close();
}

Pooled<LiveCloud> LiveRun::free_cloud() {
  Pooled<LiveCloud> cloud = clouds_->take();
  std::optional<Clock::time_point> given_up;
  while (!cloud && (!given_up || Clock::now() < *given_up)) {
    if (stopping_ && !given_up) given_up = Clock::now() + patience;
    std::this_thread::sleep_for(look_again);
    cloud = clouds_->take();
  }
  return cloud;
}

void LiveRun::make_windows() {
  std::shared_ptr<const LivePlan> current;
  std::optional<PatternWindows> windows;
  std::uint64_t lost_before = 0, resynchronised_before = 0, restarts = 0;
  std::vector<Pooled<Frame>> window;
  while (auto captured = captured_.pop()) {
    if (auto wanted = locked(plan_); wanted != current) {
      const Sequence& sequence = sequence_of(*wanted);
      if (!windows || !same_patterns(sequence, sequence_of(*current))) {
        lost_before = windows_lost_;
        resynchronised_before = resynchronisations_;
        windows.emplace(pattern_cycle(sequence), settings_.indexing, format_.size);
      }
      current = std::move(wanted);
    }
    if (captured->restarts != restarts) {
      restarts = captured->restarts;
      windows->restart();
    }
    if (!windows->put(captured->frame)) ++frames_repeated_;
    captured.reset();
    resynchronisations_ = resynchronised_before + windows->resynchronisations();
    while (windows->next(window)) {
      Pooled<LiveCloud> cloud = free_cloud();
      if (!cloud) {
        ++lost_before;
        continue;
      }
      LiveCloud& filled = cloud.fill();
      std::swap(filled.frames, window);
      window.clear();
      filled.first_pattern = windows->first_pattern();
      const auto newest = std::max_element(
          filled.frames.begin(), filled.frames.end(),
          [](const auto& a, const auto& b) { return a->stamp.sequence < b->stamp.sequence; });
      filled.newest = (*newest)->stamp;
      window_meter_.done(filled.newest.host_time);
      windows_.push_when_room({std::move(cloud), current->reconstruct});
    }
    windows_lost_ = lost_before + windows->lost();
  }
  windows_.close();
}

void LiveRun::reconstruct() {
  while (auto window = windows_.pop()) {
    LiveCloud& cloud = window->cloud.fill();
    WindowEngine& engine = *window->reconstruct;
    if (engine.is_due(cloud)) {
      std::vector<Finding> findings = engine.look(cloud);
      const std::lock_guard lock(mutex_);
      findings_.replace(std::move(findings), cloud.newest.sequence);
    }
    cloud.cleaned = engine.reconstruct(cloud);
    cloud_latency_.add(Clock::now() - cloud.newest.host_time);
    std::string backend = engine.used->backend_for(engine.views);
    std::string failure = engine.used->gpu_failure();
    {
      const std::lock_guard lock(mutex_);
      backend_ = std::move(backend);
      gpu_failure_ = std::move(failure);
    }
    reconstruct_meter_.done(cloud.newest.host_time);
    finished_.push_when_room(std::move(window->cloud));
  }
  finished_.close();
}

void LiveRun::show() {
  while (auto cloud = finished_.pop()) {
    {
      const std::lock_guard lock(mutex_);
      if ((*cloud)->first_pattern == 0) newest_ = *cloud;
    }
    followed_.follow(*cloud);
    if (settings_.on_cloud) settings_.on_cloud(*cloud);
    show_meter_.done((*cloud)->newest.host_time);
  }
}

LiveStatistics LiveRun::statistics() const {
  LiveStatistics statistics;
  statistics.frames = {.captured = frames_captured_,
                       .lost = frames_lost_,
                       .overwritten = frames_overwritten_,
                       .repeated = frames_repeated_};
  statistics.clouds = show_meter_.count();
  statistics.windows_lost = windows_lost_;
  statistics.resynchronisations = resynchronisations_;
  const Clock::time_point now = locked(end_).value_or(Clock::now());
  statistics.seconds = std::chrono::duration<double>(now - start_).count();
  statistics.clouds_per_second = static_cast<double>(statistics.clouds) / statistics.seconds;
  statistics.latency = cloud_latency_.latency();
  statistics.screen_latency = screen_latency_.latency();
  const auto add = [&](const char* name, const StageMeter& meter, std::size_t waiting,
                       std::size_t capacity) {
    StageStatistics stage = meter.statistics(now);
    stage.name = name;
    stage.waiting = waiting;
    stage.capacity = capacity;
    statistics.stages.push_back(std::move(stage));
  };
  add("capture", capture_meter_, 0, 0);
  add("window", window_meter_, captured_.waiting(), captured_.capacity());
  add("reconstruct", reconstruct_meter_, windows_.waiting(), windows_.capacity());
  add("show", show_meter_, finished_.waiting(), finished_.capacity());
  statistics.source_state = source_.state();
  followed_.add_to(statistics);
  const std::lock_guard lock(mutex_);
  statistics.findings = findings_.current();
  if (newest_) {
    statistics.cleaned = newest_->cleaned;
    statistics.motion = newest_->motion;
    statistics.backend = backend_;
  }
  return statistics;
}

}  // namespace slipstream
