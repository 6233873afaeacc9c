#include "slipstream/io/recorder.h"

#include <exception>

namespace slipstream {

Recorder::Recorder(const std::filesystem::path& path, const RecordingHeader& header,
                   std::size_t memory)
    : writer_(path, header),
      pool_(std::clamp<std::size_t>(memory / byte_count(header.format), 8, 1024),
            [&] { return Frame(header.format); }),
      thread_([this] { write_all(); }) {}

Recorder::~Recorder() {
  try {
    finish();
  } catch (const WorldError&) {
    // error() has the reason; a destructor must not throw.
  }
}

bool Recorder::record(const Frame& frame, std::chrono::milliseconds patience) {
  Pooled<Frame> kept;
  {
    std::unique_lock lock(mutex_);
    room_.wait_for(lock, patience, [&] { return ended_ || (kept = pool_.take()); });
    if (ended_) return false;
    if (!kept) {
      ++counts_.lost;
      return false;
    }
  }
  kept.fill() = frame;
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return false;
    waiting_.push_back(std::move(kept));
  }
  changed_.notify_one();
  return true;
}

void Recorder::finish() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
  if (const std::string reason = error(); !reason.empty()) throw WorldError(reason);
}

Recorder::Counts Recorder::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::string Recorder::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

void Recorder::write_all() {
  std::vector<Pooled<Frame>> taken;
  try {
    while (true) {
      taken.clear();
      {
        std::unique_lock lock(mutex_);
        counts_.written = writer_.count();
        changed_.wait(lock, [&] { return !waiting_.empty() || ended_; });
        if (waiting_.empty()) break;
        taken.swap(waiting_);
      }
      for (Pooled<Frame>& frame : taken) {
        writer_.append(*frame);
        {
          // Frees its memory for the next frame. Under the mutex: otherwise a thread that has found
          // no room and is about to wait would miss the notification.
          const std::lock_guard lock(mutex_);
          frame = {};
        }
        room_.notify_one();
      }
    }
    writer_.finish();
    const std::lock_guard lock(mutex_);
    counts_.written = writer_.count();
  } catch (const std::exception& failure) {
    const std::lock_guard lock(mutex_);
    error_ = failure.what();
    counts_.written = writer_.count();
    ended_ = true;
    waiting_.clear();
    room_.notify_one();
  }
}

std::int64_t record_frames(FrameSource& source, Recorder& recorder,
                           const std::function<bool(std::int64_t frames)>& ends,
                           const std::function<void()>& taken,
                           const std::function<void(const std::string& state)>& told) {
  // A source without its own pace can wait for the disk.
  const std::chrono::milliseconds patience(source.has_own_pace() ? 0 : 60000), most_wait(100);
  std::int64_t frames = 0;
  std::string state;
  Frame frame(source.format());
  while (!ends(frames) && recorder.error().empty()) {
    const Arrival arrival = source.next(frame, most_wait);
    if (arrival == Arrival::ended) break;
    if (const std::string now = source.state(); now != state) {
      state = now;
      told(state);
    }
    if (arrival != Arrival::frame) continue;
    recorder.record(frame, patience);
    ++frames;
    taken();
  }
  return frames;
}

RecordedSource::RecordedSource(std::unique_ptr<FrameSource> source, RecordingHeader header)
    : source_(std::move(source)), header_(std::move(header)) {
  header_.format = source_->format();
}

void RecordedSource::set_strategy(const Strategy& strategy) {
  const std::lock_guard lock(mutex_);
  if (header_.sequence) header_.sequence->strategy = strategy;
}

void RecordedSource::record_to(const std::filesystem::path& path) {
  finish_recording();
  RecordingHeader header;
  {
    const std::lock_guard lock(mutex_);
    header = header_;
  }
  auto recorder = std::make_shared<Recorder>(path, header);
  const std::lock_guard lock(mutex_);
  path_ = path;
  recorder_ = std::move(recorder);
}

void RecordedSource::finish_recording() {
  std::shared_ptr<Recorder> ended;
  {
    const std::lock_guard lock(mutex_);
    ended.swap(recorder_);
  }
  if (ended) ended->finish();
}

std::optional<RecordedSource::Recording> RecordedSource::recording() const {
  const std::lock_guard lock(mutex_);
  if (!recorder_) return std::nullopt;
  return Recording{path_, recorder_->counts(), recorder_->error()};
}

Arrival RecordedSource::next(Frame& frame, std::chrono::milliseconds timeout) {
  const Arrival arrival = source_->next(frame, timeout);
  if (arrival == Arrival::frame) {
    if (const std::shared_ptr<Recorder> current = recorder()) current->record(frame);
  }
  return arrival;
}

std::string RecordedSource::state() const {
  std::string state = source_->state();
  if (state.empty()) {
    if (const std::shared_ptr<Recorder> current = recorder()) state = current->error();
  }
  return state;
}

std::shared_ptr<Recorder> RecordedSource::recorder() const {
  const std::lock_guard lock(mutex_);
  return recorder_;
}

std::string text_of(const RecordedSource::Recording& recording) {
  if (!recording.error.empty()) return recording.error;
  std::string text =
      fmt::format("{}, {} frames", recording.path.string(), recording.counts.written);
  if (recording.counts.lost != 0) text += fmt::format(", {} lost", recording.counts.lost);
  return text;
}

}  // namespace slipstream
