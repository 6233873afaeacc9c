#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/frame_set.h"
#include "slipstream/frame_source.h"
#include "slipstream/scanner.h"
#include "slipstream/sequence.h"

namespace slipstream {

class InputFile;
class OutputFile;
/// When a file that is being written gets its own name: see OutputFile.
enum class FileWriting : int;

/// Header of a recording. docs/reference/clouds-and-recordings.md specifies the file's layout.
struct RecordingHeader {
  FrameFormat format;
  double frame_rate = 0;               ///< requested pictures per second; 0 if unknown
  std::optional<Sequence> sequence{};  ///< shown by the frames; nullopt if unknown
  std::optional<Scanner> scanner{};    ///< of the camera; nullopt if unknown
  /// Frames 3 n to 3 n + 2 are the channels of colour picture n, see colour_channels.h.
  bool in_colour = false;
  FrameSet white{};  ///< in colour: the channels of a white picture, see unmixed; may be empty
  Temperatures temperatures{};  ///< of the camera at the start, stored with `sequence`
};

/// Bounds a file that grows during a run: a recording or an MCAP file.
struct FileLimit {
  std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();
  double seconds = std::numeric_limits<double>::infinity();
  /// Keeps the newest data instead of stopping: at half the limit the file becomes NAME-before,
  /// replacing the previous one of this run, and a new file begins.
  bool ring = false;
};

/// Parses e.g. "500MB", "20GB", "2TB", "90s", "10min", "2h" or "20GB,ring". Throws Error.
FileLimit file_limit_from(const std::string& text);

/// Whether `path` is a file that begins like a recording.
bool is_recording(const std::filesystem::path& path);

/// Writes frames losslessly, one after another. However writing ends, the file can be read up to
/// the last complete frame. An existing file stays until the new one, under a temporary name until
/// then, is complete.
class RecordingWriter {
 public:
  /// Throws Error for an invalid header, WorldError if the file cannot be created; then leaves no
  /// file.
  RecordingWriter(const std::filesystem::path& path, const RecordingHeader& header);
  /// The same, with frames that last only once the file is whole if written at once.
  RecordingWriter(const std::filesystem::path& path, const RecordingHeader& header,
                  FileWriting writing);

  /// Closes the file. Without finish(), a file with frames written `over_time` reads as
  /// interrupted; otherwise an existing file stays.
  ~RecordingWriter();

  /// Throws Error if the frame's format differs from the header's, WorldError if it cannot be
  /// written: a file written `over_time` then ends with the previous frame and is closed, and the
  /// error states how many frames are on disk. Without frames, or `at_once`, an existing file
  /// stays.
  void append(const Frame& frame);

  /// Marks the end and closes the file. Without frames, an existing file stays. Throws WorldError
  /// if that fails.
  void finish();

  /// Frames in the file.
  [[nodiscard]] std::uint64_t count() const { return count_; }

  /// Bytes of a complete file with `frames` frames.
  [[nodiscard]] std::uint64_t size_of(std::uint64_t frames) const;

 private:
  void write(std::initializer_list<std::span<const std::uint8_t>> parts);

  /// Whether an unfinished file stays.
  [[nodiscard]] bool keeps_frames() const;

  std::filesystem::path path_;
  std::unique_ptr<OutputFile> file_;  ///< null once closed
  FileWriting writing_;
  FrameFormat format_;
  std::uint64_t header_size_ = 0;
  std::uint64_t count_ = 0;
  std::chrono::steady_clock::time_point first_host_time_;
};

/// Reads recordings, with random access to frames.
class RecordingReader {
 public:
  /// Throws Error with the file's name if it is missing, not a recording, or has a damaged header.
  /// An interrupted recording opens up to its last complete frame.
  explicit RecordingReader(const std::filesystem::path& path);
  ~RecordingReader();

  [[nodiscard]] const RecordingHeader& header() const { return header_; }
  [[nodiscard]] std::uint64_t count() const { return count_; }

  /// Whether the recording was ended by finish().
  [[nodiscard]] bool finished() const { return finished_; }

  /// Number of incomplete frames dropped from the end of an interrupted recording. If the last
  /// 256 MiB contain no complete frame, earlier ones are found by bisection.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

  /// Reads frame `index` (below count()) into `frame`; reuses its memory if the format matches. The
  /// host time is relative to the first frame's. Returns false if the checksum differs; the frame's
  /// contents are then unspecified.
  bool read(std::uint64_t index, Frame& frame) const;

  /// Checksum of the header and frames `first` to `end` (exclusive), continued from `before`. Uses
  /// the frames' stored checksums without reading pixels.
  [[nodiscard]] std::uint32_t checksum(std::uint64_t first, std::uint64_t end,
                                       std::uint32_t before) const;

 private:
  /// Returns the texts of the scan and of the scanner.
  std::pair<std::string, std::string> read_header();

  void find_end();

  std::filesystem::path path_;
  std::unique_ptr<const InputFile> file_;
  std::uint64_t header_size_ = 0;
  std::uint32_t header_checksum_ = 0;
  RecordingHeader header_;
  std::uint64_t count_ = 0;
  std::uint64_t dropped_ = 0;
  bool finished_ = false;
};

/// Number of windows of a recording that shows that sequence: consecutive cycles from the first
/// pattern on; with motion frames, only cycles followed by these count.
std::uint64_t window_count(const RecordingReader& recording, const Sequence& sequence);

/// The frames of a window below window_count or, without one, of the first complete cycle, in
/// pattern order; nullopt if lost or damaged frames leave no complete cycle there.
std::optional<FrameSet> window_at(const RecordingReader& recording, const Sequence& sequence,
                                  std::optional<std::uint64_t> window);

/// RecordingReader::checksum of the frames that window_at reads.
std::uint32_t cycle_checksum(const RecordingReader& recording, const Sequence& sequence,
                             std::optional<std::uint64_t> window, std::uint32_t before);

/// The frames of a scan as camera frames, stamped with their indices. Throws Error with `name` if
/// they are not possible camera frames.
std::vector<Frame> frames_of(const FrameViews& scan, const std::string& name);

}  // namespace slipstream
