#include "io/recorder.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/file_names.h"
#include "slipstream/recording.h"

namespace slipstream {

LimitedFile::LimitedFile(const std::filesystem::path& file, const FileLimit& limit)
    : path(output_target(file)), limit_(limit) {
  if (!limit_.ring) return;

  // A ring keeps two files, so each gets half the limit.
  limit_.bytes /= 2;
  limit_.seconds /= 2;

  const std::string name = path.stem().string() + "-before" + path.extension().string();
  before_ = free_path(path.parent_path() / name);
}

bool LimitedFile::is_full(std::uint64_t bytes) const {
  const std::chrono::duration<double> age = std::chrono::steady_clock::now() - begun_;
  return bytes > limit_.bytes || age.count() >= limit_.seconds;
}

bool LimitedFile::goes_on() {
  if (!limit_.ring) return false;

  std::filesystem::rename(path, before_);
  begun_ = std::chrono::steady_clock::now();
  return true;
}

std::string LimitedFile::message() const {
  return fmt::format(
      "{}: limit reached, {}", path.string(),
      limit_.ring ? "older data are in " + before_.string() + " or gone" : "recording stopped");
}

Recorder::Recorder(const std::filesystem::path& path, const RecordingHeader& header,
                   std::size_t memory, const FileLimit& limit)
    : file_(path, limit),
      header_(header),
      writer_(std::in_place, path, header),
      pool_(std::clamp<std::size_t>(memory / byte_count(header.format), 8, 1024),
            [&] { return Frame(header.format); }),
      thread_([this] { write_all(); }) {}

Recorder::~Recorder() {
  try {
    finish();
  } catch (const WorldError&) {
    // status() has the reason; a destructor must not throw.
  }
}

bool Recorder::record(const Frame& frame, std::chrono::milliseconds patience) {
  Pooled<Frame> kept;
  std::unique_lock lock(mutex_);
  room_.wait_for(lock, patience, [&] { return status_.ended || (kept = pool_.take()); });
  if (status_.ended) return false;

  if (!kept) {
    ++status_.lost;
    return false;
  }

  // Copies the pixels without the mutex: only this thread uses `kept`.
  lock.unlock();
  kept.fill() = frame;

  lock.lock();
  if (status_.ended) return false;

  waiting_.push_back(std::move(kept));
  lock.unlock();
  changed_.notify_one();

  return true;
}

void Recorder::finish() {
  {
    const std::lock_guard lock(mutex_);
    status_.ended = true;
  }

  // The thread first writes the frames that wait.
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();

  if (const std::string reason = status().error; !reason.empty()) throw WorldError(reason);
}

Recorder::Status Recorder::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

/// Completes the full file; returns whether a new one has begun.
bool Recorder::end_at_limit() {
  writer_->finish();
  writer_.reset();

  const bool goes_on = file_.goes_on();
  if (goes_on) writer_.emplace(file_.path, header_);

  const std::lock_guard lock(mutex_);
  status_.limited = file_.message();
  if (goes_on) return true;

  // No new file: releases a thread that waits for room.
  status_.ended = true;
  waiting_.clear();
  room_.notify_one();
  return false;
}

void Recorder::write_all() {
  std::vector<Pooled<Frame>> taken;
  try {
    while (true) {
      taken.clear();

      // Takes all waiting frames at once, to keep the mutex only briefly.
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !waiting_.empty() || status_.ended; });
        if (waiting_.empty()) break;
        taken.swap(waiting_);
      }

      for (Pooled<Frame>& frame : taken) {
        const std::uint64_t with_this = writer_->size_of(writer_->count() + 1);
        if (writer_->count() > 0 && file_.is_full(with_this) && !end_at_limit()) break;

        writer_->append(*frame);
        {
          // Frees its memory for the next frame. Under the mutex: otherwise a thread that has found
          // no room and is about to wait would miss the notification.
          const std::lock_guard lock(mutex_);
          ++status_.written;
          frame = {};
        }

        room_.notify_one();
      }
    }

    if (writer_) writer_->finish();
  } catch (const std::exception& failure) {
    const std::lock_guard lock(mutex_);
    status_.error = failure.what();
    status_.ended = true;
    waiting_.clear();
    room_.notify_one();
  }
}

std::int64_t record_frames(FrameSource& source, Recorder& recorder,
                           const std::function<bool(std::int64_t frames)>& ends,
                           const std::function<void()>& taken,
                           const std::function<void(const std::string& state)>& on_state) {
  // A source without its own pace can wait for the disk.
  const std::chrono::milliseconds patience(source.has_own_pace() ? 0 : 60000), most_wait(100);
  std::int64_t frames = 0;
  std::string state;
  Frame frame(source.format());
  while (!ends(frames) && !recorder.status().ended) {
    const Arrival arrival = source.next(frame, most_wait);
    if (arrival == Arrival::ended) break;
    if (const std::string now = source.state(); now != state) {
      state = now;
      on_state(state);
    }
    if (arrival != Arrival::frame) continue;
    recorder.record(frame, patience);
    ++frames;
    taken();
  }
  return frames;
}

RecordedSource::RecordedSource(std::unique_ptr<FrameSource> source, RecordingHeader header,
                               const FileLimit& limit)
    : SourceOver(std::move(source)), limit_(limit), header_(std::move(header)) {
  header_.format = source_->format();
}

void RecordedSource::set_strategy(const Strategy& strategy) {
  const std::lock_guard lock(mutex_);
  if (header_.sequence) header_.sequence->strategy = strategy;
}

void RecordedSource::record_to(const std::filesystem::path& path) {
  finish_recording();
  RecordingHeader header = locked(header_);
  header.temperatures = temperatures_of(*source_);
  auto recorder = std::make_shared<Recorder>(path, header, Recorder::default_memory, limit_);
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
  return Recording{recorder_->status(), path_};
}

Arrival RecordedSource::next(Frame& frame, std::chrono::milliseconds timeout) {
  const Arrival arrival = source_->next(frame, timeout);
  if (arrival == Arrival::frame) {
    if (const auto current = locked(recorder_)) current->record(frame);
  }
  return arrival;
}

std::string RecordedSource::state() const {
  const std::string state = source_->state();
  const auto current = locked(recorder_);
  return state.empty() && current ? current->status().error : state;
}

std::string text_of(const RecordedSource::Recording& recording) {
  if (!recording.error.empty()) return recording.error;
  std::string text = fmt::format("{}, {} frames", recording.path.string(), recording.written);
  if (recording.lost != 0) text += fmt::format(", {} lost", recording.lost);
  if (!recording.limited.empty()) text += ", limit reached";
  return text;
}

}  // namespace slipstream
