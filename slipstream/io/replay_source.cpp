#include "slipstream/io/replay_source.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/recorded_cycle.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream {
namespace fs = std::filesystem;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

namespace {

/// Frames that came faster came from memory, as the virtual scanner's without a rate.
constexpr std::chrono::microseconds shortest_interval(200);

}  // namespace

ReplaySource::ReplaySource(const fs::path& path, const ReplaySettings& settings)
    : settings_(settings) {
  if (settings.rate && !(*settings.rate >= 0 && std::isfinite(*settings.rate))) {
    throw Error(fmt::format(
        "a replay at {} frames per second is not possible; 0 (as fast as it goes) or more",
        *settings.rate));
  }
  if (fs::is_directory(path)) {
    open_folder(path);
  } else {
    open_recording(path);
  }
  measure_round(path);
  ahead_ = Frame(header_.format);
}

void ReplaySource::open_recording(const fs::path& path) {
  reader_ = std::make_unique<RecordingReader>(path);
  header_ = reader_->header();
  count_ = reader_->count();
  paced_ = settings_.rate != 0.0;
  if (!reader_->finished()) {
    warning_ = fmt::format("{}: was interrupted; {} whole frames are in it, {} were dropped",
                           path.string(), count_, reader_->dropped());
  }
  if (count_ == 0) throw Error(fmt::format("{}: has no whole frame", path.string()));
}

void ReplaySource::open_folder(const fs::path& folder) {
  const ScanFiles files = scan_files_in(folder, settings_.scan);
  header_.in_colour = is_in_colour(files);
  const Scan scan = header_.in_colour ? load_as_taken(files, header_.white) : load_scan(files);
  frames_ = frames_of(scan.frames, folder.string());
  count_ = frames_.size();
  paced_ = settings_.rate.value_or(0) > 0;
  header_.format = frames_.front().format();
  header_.sequence = scan.sequence;
  header_.sequence->marker = false;  // the folder's frames are the patterns alone
  header_.scanner = scan.scanner;
  warning_ = fmt::format("{}", fmt::join(scan.warnings, "; "));
}

void ReplaySource::measure_round(const fs::path& path) {
  Frame first, last;
  std::uint64_t from = 0, to = count_;
  while (from < count_ && !read(from, first)) ++from;
  while (to > from && !read(to - 1, last)) --to;
  if (from == to) {
    throw Error(fmt::format("{}: no frame of the recording is whole; all checksums disagree",
                            path.string()));
  }
  const std::uint64_t pattern_count =
      header_.sequence ? static_cast<std::uint64_t>(cycle_length(*header_.sequence)) : 1;
  first_sequence_ = first.stamp.sequence / pattern_count * pattern_count;
  first_host_time_ = first.stamp.host_time;
  const std::uint64_t sequences = last.stamp.sequence - first.stamp.sequence + 1;
  const std::uint64_t whole = sequences / pattern_count * pattern_count;
  round_.sequence = whole > 0 ? whole : pattern_count;
  if (settings_.loop && whole > 0) {  // what follows the last whole cycle would be a gap each round
    while (last.stamp.sequence >= first.stamp.sequence + whole) {
      do --to;
      while (!read(to - 1, last));
    }
    count_ = to;
  }
  // From the last frame to the first again it is as long as from one to the next in the mean.
  const auto intervals = static_cast<nanoseconds::rep>(std::max<std::uint64_t>(to - from - 1, 1));
  const auto with_one_more = [&](nanoseconds span) { return span + span / intervals; };
  round_.device_time = with_one_more(last.stamp.device_time - first.stamp.device_time);
  round_.host_time = with_one_more(last.stamp.host_time - first.stamp.host_time);
  if (!settings_.rate && round_.host_time < (to - from) * shortest_interval) paced_ = false;
}

bool ReplaySource::read(std::uint64_t index, Frame& frame) const {
  if (reader_) return reader_->read(index, frame);
  frame = frames_[index];
  return true;
}

void ReplaySource::start() {
  started_ = steady_clock::now();
  next_ = 0;
  is_ahead_ = false;
}

bool ReplaySource::read_ahead() {
  const std::uint64_t round = next_ / count_;
  if (round > 0 && !settings_.loop) return false;
  ahead_is_whole_ = read(next_ % count_, ahead_);
  FrameStamp& stamp = ahead_.stamp;
  stamp.sequence += round * round_.sequence - first_sequence_;
  const auto rounds = static_cast<nanoseconds::rep>(round);
  stamp.device_time += rounds * round_.device_time;
  stamp.host_time += rounds * round_.host_time;
  ++next_;
  is_ahead_ = true;
  return true;
}

steady_clock::time_point ReplaySource::due() const {
  if (!ahead_is_whole_) return started_;  // nobody knows when
  if (settings_.rate) {
    const std::uint64_t taken = (next_ - 1) / (header_.in_colour ? 3 : 1);  // before, at once
    const std::chrono::duration<double> since(static_cast<double>(taken) / *settings_.rate);
    return started_ + std::chrono::duration_cast<steady_clock::duration>(since);
  }
  return started_ + (ahead_.stamp.host_time - first_host_time_);
}

Arrival ReplaySource::next(Frame& frame, std::chrono::milliseconds timeout) {
  if (!is_ahead_ && !read_ahead()) return Arrival::ended;
  if (paced_) {
    const steady_clock::time_point latest = steady_clock::now() + timeout;
    const steady_clock::time_point then = due();
    std::this_thread::sleep_until(std::min(then, latest));
    if (then > latest) return Arrival::nothing;
  }
  is_ahead_ = false;
  if (!ahead_is_whole_) {
    ++damaged_;
    return Arrival::damaged;
  }
  frame.pixels.swap(ahead_.pixels);  // the memory changes hands; no pixel is copied
  std::swap(frame.bits, ahead_.bits);
  frame.stamp = ahead_.stamp;
  frame.stamp.host_time = steady_clock::now();
  ++delivered_;
  return Arrival::frame;
}

SourceCounters ReplaySource::counters() const {
  return {.delivered = delivered_, .lost = damaged_};
}

}  // namespace slipstream
