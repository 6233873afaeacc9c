#include "app/convert_frames.h"

#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/number_text.h"
#include "slipstream/io/file.h"
#include "slipstream/io/recorded_cycle.h"
#include "slipstream/io/recording.h"
#include "slipstream/io/replay_source.h"
#include "slipstream/io/result_files.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/publish/mcap_reader.h"
#include "slipstream/publish/ros_messages.h"

namespace slipstream::app {
namespace {

/// Frames of several inputs in one recording; where one ends the next begins with a cycle.
class JoinedRecording {
 public:
  JoinedRecording(std::string path, std::size_t inputs) : path_(std::move(path)), inputs_(inputs) {}

  void begin(RecordingHeader header, const std::string& input) {
    if (writer_ && (header.format != header_.format || header.sequence != header_.sequence ||
                    header.scanner != header_.scanner || header.in_colour != header_.in_colour)) {
      throw Error(
          fmt::format("{}: of another camera, strategy or scanner than those before", input));
    }
    if (inputs_ > 1 && header.white.count() != 0) {
      throw Error(fmt::format(
          "{}: has a white picture, of which a recording holds one; convert it alone", input));
    }
    if (!writer_) writer_.emplace(path_, header);
    header_ = std::move(header);
    const auto cycle =
        static_cast<std::uint64_t>(header_.sequence ? cycle_length(*header_.sequence) : 1);
    first_ = (next_ + cycle - 1) / cycle * cycle;
  }
  void add(Frame& frame) {
    frame.stamp.sequence += first_;
    next_ = frame.stamp.sequence + 1;
    writer_->append(frame);
  }
  std::uint64_t finish() {
    if (!writer_ || writer_->count() == 0) throw Error("no frame came that could be written");
    writer_->finish();
    return writer_->count();
  }

 private:
  std::string path_;
  std::size_t inputs_;
  RecordingHeader header_;
  std::optional<RecordingWriter> writer_;
  std::uint64_t first_ = 0, next_ = 0;  ///< in the recording's count of frames
};

void add_replayed(const std::string& path, JoinedRecording& recording, Output& output) {
  ReplaySource source(path, {.rate = 0});
  if (!source.warning().empty()) output.warn(source.warning());
  recording.begin(source.header(), path);
  Frame frame(source.format());
  source.start();
  for (Arrival arrival{}; (arrival = source.next(frame, {})) != Arrival::ended;) {
    if (arrival == Arrival::frame) recording.add(frame);
  }
}

/// What is attached to an MCAP file and its topics /frames/0, /frames/1, ... say.
void add_published(const std::string& path, JoinedRecording& recording, Output& output) {
  constexpr std::string_view frames = "/frames/";
  std::optional<ScanFiles> scan;
  std::optional<Scanner> scanner;
  std::optional<std::uint32_t> first;
  const bool whole = read_mcap(path, [&](const McapMessage& message) {
    const std::string text(message.content.begin(), message.content.end());
    if (message.encoding.empty() && message.topic == "scanner.yaml") {
      scanner = scanner_from(text, message.topic);
    } else if (message.encoding.empty() && message.topic == "scan.yaml") {
      if (scan) throw Error("its strategy changes; a recording has one");
      scan = scan_files_from(text, message.topic, {});
    } else if (scan && message.type == image_type().name && message.topic.starts_with(frames)) {
      const auto pattern = number_in<int>(message.topic.substr(frames.size()));
      Frame frame = read_frame(message.content, scan->bits);
      if (!first) {
        recording.begin({.format = frame.format(), .sequence = scan->sequence, .scanner = scanner},
                        path);
        first = message.number - static_cast<std::uint32_t>(pattern.value_or(0));
      }
      frame.stamp = {.sequence = message.number - *first,
                     .pattern_index = pattern,
                     .device_time = std::chrono::nanoseconds(message.time),
                     .host_time = std::chrono::steady_clock::time_point(
                         std::chrono::nanoseconds(message.time))};
      recording.add(frame);
    }
  });
  if (!whole) output.warn(fmt::format("{}: has no end; its chunks that are whole were read", path));
  if (!first)
    throw Error(fmt::format("{}: has no frames of a scan, as live scans write them", path));
}

}  // namespace

bool is_mcap(const std::string& path) {
  return lower_case_extension(path) == ".mcap";
}

void refuse_second(const std::string& path) {
  throw Error(
      fmt::format("{}: two clouds or scans would be written to it; {{name}} and {{window}} in -o "
                  "stand for the input's name and the number in it",
                  path));
}

void convert_to_recording(const std::vector<std::string>& paths, const std::string& path,
                          Output& output) {
  JoinedRecording recording(path, paths.size());
  for (const std::string& input : paths) {
    is_mcap(input) ? add_published(input, recording, output)
                   : add_replayed(input, recording, output);
  }
  const std::uint64_t frames = recording.finish();
  output.say("{}: {} frames", path, frames);
  output.document["frames"] = frames;
  output.document["files"] = {path};
}

void convert_to_folders(const std::vector<std::string>& recordings, const std::string& folder,
                        const ScanChanges& changes, Output& output) {
  std::set<std::string> written;
  for (const std::string& path : recordings) {
    const RecordingReader recording(path);
    const ScanFiles scan = scan_files_in(path, changes);
    std::optional<Scanner> scanner;
    if (scan.scanner) scanner = read_scanner(*scan.scanner);
    const Sequence& sequence = scan.sequence;
    for (std::uint64_t window = 0; window < window_count(recording, sequence); ++window) {
      const std::optional<FrameSet> frames = window_at(recording, sequence, window);
      const ScanName name{path, window};
      if (!frames) {
        output.warn(fmt::format("left out: {}: frames are missing or damaged", text_of(name)));
        continue;
      }
      const std::string made = files_of_scan({.cloud = folder}, name).cloud;
      if (!written.insert(made).second) refuse_second(made);
      Sequence shown = sequence;
      shown.marker = false;
      save_scan(made, *frames, shown, scanner, std::nullopt, recording.header().in_colour,
                recording.header().white);
    }
  }
  if (written.empty()) throw Error("no scan came that could be written");
  output.say("{}: {} scan folder{}", folder, written.size(), written.size() == 1 ? "" : "s");
  output.document["scans"] = written.size();
  output.document["files"] = written;
}

}  // namespace slipstream::app
