#include "slipstream/io/recorded_source.h"

#include <utility>

#include <fmt/format.h>

namespace slipstream {

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
