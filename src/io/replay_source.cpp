// Replays recorded frames: as cycles, and as if from a camera.
#include "io/replay_source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "base/throw_if-inl.h"
#include "decode/frame_adapter.h"
#include "frames/pattern_windows.h"
#include "frames/scan_camera.h"
#include "io/image_file.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner_file.h"

namespace slipstream {
namespace fs = std::filesystem;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;
namespace {

/// Cycles searched for a complete one, and cycles that PatternWindows may keep.
constexpr std::uint64_t searched_cycles = 8, kept_cycles = 4;

/// A range of frames in a recording.
struct Places {
  std::uint64_t first = 0, end = 0;      ///< last exclusive
  std::optional<std::uint64_t> least{};  ///< from which on a complete cycle begins; nullopt: any
};

/// Index of the first frame that shows pattern 0, by the first frame's stamp; unknown with a
/// marker.
std::uint64_t first_start(const RecordingReader& recording, const Sequence& sequence) {
  Frame frame;
  if (sequence.marker || recording.count() == 0 || !recording.read(0, frame)) return 0;

  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence));
  const std::optional<int> pattern = frame.stamp.pattern_index;  // never negative

  // Sources without pattern indices number their frames from pattern 0.
  const std::uint64_t index = pattern ? static_cast<std::uint64_t>(*pattern) : frame.stamp.sequence;

  return (cycle - index % cycle) % cycle;
}

/// The range searched for a window's frames, or for the first cycle.
Places searched(const RecordingReader& recording, const Sequence& sequence,
                std::optional<std::uint64_t> window) {
  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence));
  const auto motion = static_cast<std::uint64_t>(sequence.motion);
  if (!window) return {0, std::min(recording.count(), searched_cycles * (cycle + motion))};

  const std::uint64_t least = first_start(recording, sequence) + *window * cycle;

  // A marker precedes its cycle. After lost frames the next cycle begins earlier, but only one
  // complete cycle can begin within this range.
  const bool marked = sequence.marker && least >= cycle;
  const std::uint64_t end = least + 2 * cycle - (sequence.marker ? 2 : 1) + motion;
  return {marked ? least - cycle : least, std::min(end, recording.count()), least};
}

}  // namespace

std::uint32_t cycle_checksum(const RecordingReader& recording, const Sequence& sequence,
                             std::optional<std::uint64_t> window, std::uint32_t before) {
  const Places places = searched(recording, sequence, window);
  return recording.checksum(places.first, places.end, before);
}

std::uint64_t window_count(const RecordingReader& recording, const Sequence& sequence) {
  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence));

  // Frames that are in no complete window: before the first pattern 0, and the motion frames.
  const std::uint64_t before =
      first_start(recording, sequence) + static_cast<std::uint64_t>(sequence.motion);

  return recording.count() < before ? 0 : (recording.count() - before) / cycle;
}

std::optional<FrameSet> window_at(const RecordingReader& recording, const Sequence& sequence,
                                  std::optional<std::uint64_t> window) {
  const auto [first, end, least] = searched(recording, sequence, window);
  const auto cycle = static_cast<std::uint64_t>(cycle_length(sequence) + sequence.motion);

  PatternWindows windows(pattern_cycle(sequence),
                         sequence.marker ? PatternIndexing::marker : PatternIndexing::source,
                         recording.header().format.size);

  // Frames allocate their memory when read.
  Pool<Frame> pool(std::min(end - first, kept_cycles * cycle + 1), [] { return Frame(); });

  std::vector<Pooled<Frame>> found;
  for (std::uint64_t n = first; n < end; ++n) {
    Pooled<Frame> frame = pool.take();
    if (!frame) break;
    if (!recording.read(n, frame.fill())) continue;

    windows.put(frame);
    frame = {};

    // A cycle ends here: it must begin with pattern 0, not before the window, and not contain
    // frames of the next cycle.
    if (!windows.next(found) || windows.first_pattern() != 0) continue;
    const bool in_order = found.front()->stamp.sequence <= found.back()->stamp.sequence;
    if (least && (n + 1 < *least + found.size() || !in_order)) continue;

    std::vector<Frame> frames;  // not shared any more
    for (Pooled<Frame>& placed : found) frames.push_back(std::move(placed.fill()));
    return frame_set_of(std::move(frames));
  }

  return std::nullopt;
}

std::vector<Frame> frames_of(const FrameViews& scan, const std::string& name) {
  return scan.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    std::vector<Frame> frames;

    if constexpr (std::is_same_v<Pixel, double>) {
      throw Error(fmt::format(
          "{}: unquantised frames cannot be replayed; a camera has 8 to 16 bits", name));
    } else {
      throw_if(sizeof(Pixel) == 2 && scan.bits() <= 8,
               "{}: 16-bit pictures, but bits is {}; replay requires 9 to 16", name, scan.bits());

      for (const auto& view : views) {
        Frame frame({scan.size(), scan.bits()});
        auto& image = std::get<Image<Pixel>>(frame.pixels);
        for (int row = 0; row < view.height(); ++row) {
          std::copy_n(view.row(row), view.width(), image.row(row));
        }

        frame.stamp.sequence = frames.size();
        frame.stamp.pattern_index = static_cast<int>(frames.size());
        frames.push_back(std::move(frame));
      }
    }

    return frames;
  });
}

ReplaySource::ReplaySource(const fs::path& path, const ReplaySettings& settings)
    : settings_(settings) {
  const double rate = settings.rate.value_or(0);
  throw_if(!(rate >= 0 && std::isfinite(rate)),
           "replay rate {} frames per second: expected 0 (as fast as possible) or more", rate);

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
    warning_ = fmt::format("{}: was interrupted; {} complete frames, {} dropped", path.string(),
                           count_, reader_->dropped());
  }

  throw_if(count_ == 0, "{}: has no complete frame", path.string());
}

void ReplaySource::open_folder(const fs::path& folder) {
  const ScanFiles files = scan_files_in(folder, settings_.scan);
  paced_ = settings_.rate.value_or(0) > 0;

  // More frames than one cycle are read when they are due.
  if (static_cast<int>(files.frames.size()) > frame_count(files.sequence)) {
    return open_pictures(files);
  }

  header_.in_colour = is_in_colour(files);
  Scan scan = header_.in_colour ? load_as_taken(files, header_.white) : load_scan(files);
  if (!scan.other_axis.empty()) {
    scan.warnings.push_back(fmt::format("{}: only its frames along {} are replayed",
                                        folder.string(), name_of(scan.sequence.axis)));
  }

  colour_ = std::move(scan.colour);
  frames_ = frames_of(scan.frames, folder.string());
  count_ = frames_.size();

  header_.format = frames_.front().format();
  header_.sequence = scan.sequence;
  header_.sequence->marker = false;  // a folder contains no marker frame
  header_.scanner = scan.scanner;

  warning_ = fmt::format("{}", fmt::join(scan.warnings, "; "));
}

/// Each picture shows the next pattern of the cycle.
void ReplaySource::open_pictures(const ScanFiles& files) {
  throw_if(!files.order.empty(), "{}: `order` needs a single cycle of frames", files.path.string());

  pictures_ = files.frames;
  bits_ = files.bits;
  channel_ = files.channel;
  mosaic_ = files.mosaic;
  count_ = pictures_.size();

  header_.sequence = files.sequence;
  header_.sequence->marker = false;

  // The first picture gives the format of all.
  Frame frame;
  if (!read(0, frame)) throw Error(fmt::format("{}: not a frame", pictures_.front().string()));
  header_.format = frame.format();
  if (header_.format.bits > 8) bits_ = header_.format.bits;

  if (!files.scanner) return;
  header_.scanner = completed(read_scanner(*files.scanner), files.scanner->string(),
                              header_.format.size, files.sequence.projector);
  header_.sequence->projector = header_.scanner->projector.size;
}

void ReplaySource::measure_round(const fs::path& path) {
  // The first and the last whole frame.
  Frame first, last;
  std::uint64_t from = 0, to = count_;
  while (from < count_ && !read(from, first)) ++from;
  while (to > from && !read(to - 1, last)) --to;
  throw_if(from == to, "{}: no complete frame; the checksum of every frame is wrong",
           path.string());

  // The sequence starts at a multiple of the cycle, and so does each round.
  const std::uint64_t pattern_count =
      header_.sequence ? static_cast<std::uint64_t>(cycle_length(*header_.sequence)) : 1;
  first_sequence_ = first.stamp.sequence / pattern_count * pattern_count;
  first_host_time_ = first.stamp.host_time;

  const std::uint64_t sequences = last.stamp.sequence - first.stamp.sequence + 1;
  const std::uint64_t whole = sequences / pattern_count * pattern_count;
  round_.sequence = whole > 0 ? whole : pattern_count;

  if (settings_.loop && whole > 0) {  // a partial last cycle would leave a gap each round
    while (last.stamp.sequence >= first.stamp.sequence + whole) {
      do --to;
      while (!read(to - 1, last));
    }
    count_ = to;
  }

  // The interval from the last frame to the first is the mean frame interval.
  const auto intervals = static_cast<nanoseconds::rep>(std::max<std::uint64_t>(to - from - 1, 1));
  const auto with_one_more = [&](nanoseconds span) { return span + span / intervals; };
  round_.device_time = with_one_more(last.stamp.device_time - first.stamp.device_time);
  round_.host_time = with_one_more(last.stamp.host_time - first.stamp.host_time);

  // Faster frames came from memory, such as the virtual scanner's without a rate.
  constexpr std::chrono::microseconds shortest_interval(200);
  if (!settings_.rate && round_.host_time < (to - from) * shortest_interval) paced_ = false;
}

bool ReplaySource::read(std::uint64_t index, Frame& frame) const {
  if (reader_) return reader_->read(index, frame);

  if (!pictures_.empty()) {
    const auto cycle = static_cast<std::uint64_t>(cycle_length(*header_.sequence));

    try {
      const FrameReading reading{.bits = bits_, .channel = channel_, .mosaic = mosaic_};
      frame = frames_of(read_frames({pictures_[index]}, reading).frames, "").front();
    } catch (const Error&) {
      return false;
    }

    frame.stamp.sequence = index;
    frame.stamp.pattern_index = static_cast<int>(index % cycle);
    return true;
  }

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

  // Continues the stamps of the rounds before.
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
  if (!ahead_is_whole_) return started_;  // time unknown

  // At a set rate, frames are evenly spaced; the channels of a colour picture arrive together.
  if (settings_.rate) {
    const std::uint64_t taken = (next_ - 1) / (header_.in_colour ? 3 : 1);  // delivered before
    const std::chrono::duration<double> since(static_cast<double>(taken) / *settings_.rate);
    return started_ + std::chrono::duration_cast<steady_clock::duration>(since);
  }

  // At the recorded times.
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

  frame.pixels.swap(ahead_.pixels);  // without copying pixels
  std::swap(frame.bits, ahead_.bits);
  frame.stamp = ahead_.stamp;
  frame.stamp.host_time = steady_clock::now();

  ++delivered_;
  return Arrival::frame;
}

}  // namespace slipstream
