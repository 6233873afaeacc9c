#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/joined_recording.h"
#include "app/scan_flags.h"
#include "base/numbers.h"
#include "io/file.h"
#include "io/replay_source.h"
#include "io/result_files.h"
#include "io/scan_folder.h"
#include "io/scanner_urdf.h"
#include "publish/mcap.h"
#include "publish/mcap_reader.h"
#include "publish/transform_message.h"
#include "slipstream/ros_messages.h"

namespace slipstream::app {
namespace {

struct ConvertFlags {
  std::vector<std::string> paths;
  std::string output;
  std::string topic;
  ScanChanges changes;
  ScanJobSettings job;
  FlagsOfScans of_scans;
};

bool is_mcap(const std::string& path) {
  return lower_case_extension(path) == ".mcap";
}

bool holds_clouds(const std::string& path) {
  return is_mcap(path) || is_cloud_file(path);
}

void require_only(bool only, const std::string& path) {
  throw_if(!only,
           "{}: two clouds or scans would be written to this file; put {{name}} (input) or "
           "{{window}} (its number) in -o to keep them apart",
           path);
}

/// Names an input, or a window of it, that the output lacks; the other inputs go on.
void leave_out(std::string_view reason, Output& output) {
  output.tell_failure(fmt::format("left out: {}", reason));
  output.list("left_out").push_back(reason);
  output.exit_code = 2;
}

/// Warns of a recording that was cut off, and names one that holds no complete cycle.
std::uint64_t complete_windows(const RecordingReader& recording, const Sequence& sequence,
                               const std::string& path, Output& output) {
  if (!recording.finished()) {
    output.warn(fmt::format("{}: was interrupted; {} complete frames, {} dropped", path,
                            recording.count(), recording.dropped()));
  }

  const std::uint64_t windows = window_count(recording, sequence);
  if (windows == 0) {
    leave_out(fmt::format("{}: no complete cycle of {} frames; it has {}", path,
                          cycle_length(sequence) + sequence.motion, recording.count()),
              output);
  }
  return windows;
}

/// Names the parts of a scan folder that a recording does not hold.
void warn_of_other_parts(const std::string& path, const ScanChanges& changes, Output& output) {
  if (!fs::is_directory(path)) return;

  const ScanFiles files = scan_files_in(path, changes);
  if (files.guard) output.warn(fmt::format("{}: a recording holds no guard; left out", path));
  if (!files.further_cameras.empty()) {
    output.warn(fmt::format("{}: a recording holds one camera; the others are left out", path));
  }
}

/// Names the cameras of a scan folder that its cloud leaves out.
void warn_of_other_cameras(const std::string& path, const ScanChanges& changes, Output& output) {
  if (!fs::is_directory(path) || scan_files_in(path, changes).further_cameras.empty()) return;
  output.warn(
      fmt::format("{}: the cloud is of one camera; the others are left out; slipstream "
                  "reconstruct uses them",
                  path));
}

void add_replayed(const std::string& path, const ScanChanges& changes, JoinedRecording& recording,
                  Output& output) {
  ReplaySource source(path, {.rate = 0, .scan = changes});
  if (!source.warning().empty()) output.warn(source.warning());
  warn_of_other_parts(path, changes, output);

  recording.begin(source.header(), path);
  Frame frame(source.format());

  source.start();
  std::uint64_t damaged = 0;
  for (Arrival arrival{}; (arrival = source.next(frame, {})) != Arrival::ended;) {
    if (arrival == Arrival::frame) recording.add(frame);
    if (arrival == Arrival::damaged) ++damaged;
  }

  if (damaged > 0) leave_out(fmt::format("{}: {} damaged frames", path, damaged), output);
}

/// The attachments of an MCAP file and its topics /frames/0, /frames/1, ...
void add_published(const std::string& path, JoinedRecording& recording, Output& output) {
  constexpr std::string_view frames = "/frames/";
  std::optional<ScanFiles> scan;
  std::optional<Scanner> scanner;
  std::optional<std::uint32_t> first;

  // The attachments scanner.yaml and scan.yaml come before the frames that they describe.
  const bool whole = read_mcap(path, [&](const McapMessage& message) {
    const std::string text(message.content.begin(), message.content.end());
    if (message.encoding.empty() && message.topic == "scanner.yaml") {
      scanner = scanner_from(text, message.topic);
    } else if (message.encoding.empty() && message.topic == "scan.yaml") {
      throw_if(scan.has_value(), "its strategy changes, but a recording has only one");
      scan = scan_files_from(text, message.topic, {});
    } else if (scan && message.type == image_type().name && message.topic.starts_with(frames)) {
      const auto pattern = number_in<int>(message.topic.substr(frames.size()));
      Frame frame = read_frame(message.content, scan->bits);

      // The first frame sets the camera's format, and where counting starts: at pattern 0.
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

  if (!whole) output.warn(fmt::format("{}: truncated; only its complete chunks were read", path));
  throw_if(!first.has_value(), "{}: contains no scan frames written by slipstream live", path);
}

/// Joins the frames of recordings, scan folders and MCAP files of live scans into one recording.
/// Throws Error if they differ in camera or sequence.
void convert_to_recording(const std::vector<std::string>& paths, const std::string& path,
                          const ScanChanges& changes, Output& output) {
  JoinedRecording recording(path, paths.size());
  for (const std::string& input : paths) {
    if (is_mcap(input)) {
      add_published(input, recording, output);
    } else {
      add_replayed(input, changes, recording, output);
    }
  }

  const std::uint64_t frames = recording.finish();
  output.say("{}: {} frames", path, frames);
  output.document["frames"] = frames;
  output.document["files"] = {path};
}

/// Writes each complete cycle of recordings as a scan folder; `changes` override the recording's
/// sequence.
void convert_to_folders(const std::vector<std::string>& recordings, const std::string& folder,
                        const ScanChanges& changes, Output& output) {
  std::set<std::string> written;
  for (const std::string& path : recordings) {
    const RecordingReader recording(path);
    const ScanFiles scan = scan_files_in(path, changes);

    std::optional<Scanner> scanner;
    if (scan.scanner) scanner = read_scanner(*scan.scanner);
    const Sequence& sequence = scan.sequence;
    const std::uint64_t windows = complete_windows(recording, sequence, path, output);
    Progress progress("scans", windows);
    for (std::uint64_t window = 0; window < windows; ++window, progress.advance()) {
      const std::optional<FrameSet> frames = window_at(recording, sequence, window);
      const ScanName name{path, window};
      if (!frames) {
        leave_out(fmt::format("{}: frames are missing or damaged", text_of(name)), output);
        continue;
      }

      const std::string made = files_of_scan({.cloud = folder}, name).cloud;
      require_only(written.insert(made).second, made);

      Sequence shown = sequence;
      shown.marker = false;
      save_scan(made, *frames, shown,
                {.scanner = scanner,
                 .in_colour = recording.header().in_colour,
                 .white = recording.header().white});
    }
  }

  throw_if(written.empty(), "no complete scan to write");
  output.say("{}: {}", folder, counted(written.size(), "scan folder"));
  output.add("scans", written.size(), "files", written);
}

/// Nanoseconds per second: the interval between clouds without timestamps.
constexpr std::uint64_t nanoseconds = 1'000'000'000;

/// Writes clouds in order, to one MCAP file or to a file each.
class CloudFiles {
 public:
  /// `frame`: which the clouds are moved to; null: they keep theirs.
  CloudFiles(const std::string& path, std::shared_ptr<const FramePose> frame, Output& output)
      : path_(path), frame_(std::move(frame)), output_(output) {
    if (!is_mcap(path)) require_cloud_ending(path);
  }

  /// `time`: ns; nullopt: one second after the previous cloud.
  void add(const StoredCloud& stored, const ScanName& name, std::optional<std::uint64_t> time) {
    last_ = time.value_or(count_ == 0 ? 0 : last_ + nanoseconds);
    ++count_;

    if (is_mcap(path_)) {
      add_message(stored);
    } else {
      add_file(stored, name);
    }
  }

  void finish() {
    throw_if(count_ == 0, "no cloud to write");
    if (writer_) writer_->finish();

    const std::size_t files = writer_ ? 1 : written_.size();
    output_.say("{}: {} in {}", path_, counted(count_, "cloud"), counted(files, "file"));

    output_.document["clouds"] = count_;
    output_.document["files"] = writer_ ? nlohmann::json{path_} : nlohmann::json(written_);
  }

 private:
  void add_message(StoredCloud stored) {
    if (frame_) {
      move_to_frame(stored.cloud, *frame_, stored.uncertainty ? &*stored.uncertainty : nullptr);
    }

    // Channels are declared with the first cloud.
    if (!writer_) {
      writer_.emplace(path_, OutputFile::Writing::at_once);
      const RosType points = point_cloud_type(), image = image_type();
      points_ = writer_->add_channel("/points", points.name, points.definition);
      image_ = writer_->add_channel("/image", image.name, image.definition);
    }

    if (stored.organised) {
      write_image(stored.cloud, {last_}, message_);
      writer_->write(image_, last_, message_);
    }

    add_transform(stored.cloud.frame);

    write_point_cloud(stored.cloud, {last_, frame_name(stored.cloud)}, message_,
                      uncertainty_of(stored));
    writer_->write(points_, last_, message_);
    writer_->end_message_group();
  }

  /// Writes where the camera is in the frame, unless it is known already; null: the camera's.
  void add_transform(const std::shared_ptr<const FramePose>& frame) {
    const bool is_known = sent_ != nullptr && frame != nullptr && sent_->to == frame->to &&
                          sent_->transform.matrix() == frame->transform.matrix();
    if (frame == nullptr || is_known) return;

    if (!transform_) {
      const RosType type = transform_type();
      transform_ =
          writer_->add_channel(fmt::format("/{}", transform_topic), type.name, type.definition);
    }
    write_transform(*frame, camera_frame, last_, message_);
    writer_->write(*transform_, last_, message_);
    sent_ = frame;
  }

  void add_file(const StoredCloud& stored, const ScanName& name) {
    const std::string path = files_of_scan({.cloud = path_}, name).cloud;
    require_only(written_.insert(path).second, path);

    write_cloud(path, stored.cloud, {.uncertainty = uncertainty_of(stored), .frame = frame_});
  }

  const std::string path_;
  const std::shared_ptr<const FramePose> frame_;
  Output& output_;
  std::uint64_t count_ = 0, last_ = 0;
  std::optional<McapWriter> writer_;
  std::uint16_t points_ = 0, image_ = 0;
  std::optional<std::uint16_t> transform_;  ///< channel
  std::shared_ptr<const FramePose> sent_;   ///< the last one written
  RosMessage message_;
  std::set<std::string> written_;
};

/// The frames in which the camera's place is known, by name.
using CameraFrames = std::map<std::string, std::shared_ptr<const FramePose>, std::less<>>;

/// Adds the frames of a message about static transforms. Other programs may write any; one that
/// cannot be read only leaves the camera's place open.
void add_frames(const McapMessage& message, CameraFrames& frames) {
  const bool is_static = message.encoding == "cdr" && message.type == transform_type().name &&
                         message.topic == fmt::format("/{}", transform_topic);
  if (!is_static) return;

  try {
    for (FramePose& pose : read_transforms(message.content)) {
      if (pose.from != camera_frame) continue;
      const std::string name = pose.to;
      frames[name] = std::make_shared<const FramePose>(std::move(pose));
    }
  } catch (const Error&) {
  }
}

void convert_mcap(const std::string& path, const ConvertFlags& flags, CloudFiles& files,
                  Output& output) {
  const std::string& topic = flags.topic;
  std::uint64_t count = 0;
  std::set<std::string> topics;
  CameraFrames frames;
  const bool whole = read_mcap(path, [&](const McapMessage& message) {
    const bool is_cloud = message.type == point_cloud_type().name && message.encoding == "cdr";
    if (topics.size() < 16) topics.insert(message.topic + (is_cloud ? "" : " (no cloud)"));

    add_frames(message, frames);
    if (!is_cloud || (!topic.empty() && message.topic != topic)) return;

    // A cloud names its frame; a transform says where the camera is in it.
    StoredCloud stored = read_point_cloud(message.content);
    const auto known = frames.find(frame_name(stored.cloud));
    if (known != frames.end()) stored.cloud.frame = known->second;
    keep_box(stored.cloud, flags.job.reconstruct.clean);
    files.add(stored, {path, count++}, message.time);
  });

  if (!whole) output.warn(fmt::format("{}: truncated; only its complete chunks were read", path));

  // The topics found help to choose one; 16 are enough for a message.
  throw_if(count == 0, "{}: no sensor_msgs/msg/PointCloud2{}{}; its topics: {}", path,
           topic.empty() ? "" : " on ", topic,
           topics.empty() ? "none" : fmt::format("{}", fmt::join(topics, ", ")));
}

/// Reconstructs each complete cycle, and names those that it leaves out.
void convert_recording(const std::string& path, const ConvertFlags& flags, CloudFiles& files,
                       Output& output) {
  const RecordingReader recording(path);
  ScanChanges changes = flags.changes;
  const Sequence sequence = scan_files_in(path, changes).sequence;

  // A colour picture holds three patterns, so patterns come three times as fast.
  const double rate = (recording.header().in_colour ? 3 : 1) * recording.header().frame_rate;
  const double cycle = rate > 0 ? static_cast<double>(cycle_length(sequence)) / rate : 1;

  const std::uint64_t windows = complete_windows(recording, sequence, path, output);
  Progress progress("clouds", windows);
  for (std::uint64_t window = 0; window < windows; ++window, progress.advance()) {
    changes.window = window;
    const auto time = static_cast<std::uint64_t>(static_cast<double>(window) * cycle * nanoseconds);

    std::optional<StoredCloud> stored;
    try {
      stored = organised_cloud(path, changes, flags.job, output);
    } catch (const Error& error) {
      leave_out(error.what(), output);
      continue;
    }

    files.add(*stored, {path, window}, time);
  }
}

/// Writes the frames of a scanner file for ROS.
void convert_to_frames(const std::vector<std::string>& paths, const std::string& path,
                       Output& output) {
  throw_if(paths.size() != 1, "{}: describes one scanner; name one scanner file", path);
  const Scanner scanner = read_scanner(paths.front());
  write_file(path, naming(paths.front(), [&] {
               return lower_case_extension(path) == ".urdf" ? urdf_of(scanner) : xacro_of(scanner);
             }));

  output.say("{}: frames camera_link, camera_optical and projector", path);
  output.document["files"] = {path};
}

void convert(const ConvertFlags& flags, Output& output) {
  const std::string ending = lower_case_extension(flags.output);
  if (ending == ".urdf" || ending == ".xacro") {
    return convert_to_frames(flags.paths, flags.output, output);
  }
  if (ending == ".slip")
    return convert_to_recording(flags.paths, flags.output, flags.changes, output);
  if (ending.empty()) return convert_to_folders(flags.paths, flags.output, flags.changes, output);

  if (std::ranges::all_of(flags.paths, holds_clouds)) {
    flags.of_scans.refuse_for_cloud(flags.paths.front());
  }
  CloudFiles files(flags.output, wanted_frame(flags.job.reconstruct), output);
  const bool one_file = !is_mcap(flags.output) && flags.output.find('{') == std::string::npos;
  require_only(!one_file || flags.paths.size() == 1, flags.output);

  for (const std::string& path : flags.paths) {
    output.tell_wait(path + ": converting");
    if (is_mcap(path)) {
      convert_mcap(path, flags, files, output);
    } else if (is_cloud_file(path)) {
      StoredCloud stored = loaded_cloud(path, output);
      keep_box(stored.cloud, flags.job.reconstruct.clean);
      files.add(stored, {path}, std::nullopt);
    } else if (is_recording(path)) {
      convert_recording(path, flags, files, output);
    } else {
      warn_of_other_cameras(path, flags.changes, output);
      files.add(organised_cloud(path, flags.changes, flags.job, output), {path}, std::nullopt);
    }
  }

  files.finish();
}

}  // namespace

void add_convert(const Commands& program) {
  const auto [command, flags] = program.add(convert, "convert",
                                            "convert clouds and scans to MCAP, PLY, PCD or XYZ, "
                                            "frames to recordings or scan folders, and scanner "
                                            "files to URDF");

  required(command.add_file(
      "input", flags.paths,
      "MCAP files, clouds, recordings (each cycle) and scan folders, in this order; or a scanner "
      "file"));
  required(command.add_output(
      "-o,--output", flags.output,
      ".mcap: all clouds in one file; .ply, .pcd or .xyz: one file each, with {name} for the "
      "input's name and {window} for the cloud's number; .slip: all frames in one recording; no "
      "extension: a scan folder per recorded cycle; .urdf or .xacro: the scanner file's frames, "
      "for ROS"));

  command.add("--topic", flags.topic, "MCAP input: convert only this topic's clouds, e.g. /points");
  const std::size_t before = command.app.get_options().size();
  add_cloud_flags(command.app, flags.changes, flags.job);
  flags.of_scans = flags_of_scans(command.app, before, {"--anyway", "--box", "--to-frame"});

  command.common(
      {"--output", "--topic", "--scanner", "--minimum-modulation", "--largest-sigma", "--raw"});
  command.examples({"convert scan.slip -o clouds.mcap",
                    "convert clouds.mcap -o clouds/{window}.pcd",
                    "convert clouds.mcap -o scan.slip", "convert scanner.yaml -o scanner.urdf"});
}

}  // namespace slipstream::app
