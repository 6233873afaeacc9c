#pragma once

#include "slipstream/codes/sequence.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/io/file.h"

namespace slipstream {

/// What a recording says of all its frames. The file's layout, byte by byte, is in docs/reference/files.md.
struct RecordingHeader {
  FrameFormat format;
  double frame_rate = 0;  ///< pictures per second asked of the camera; 0 where not known
  std::optional<Sequence> sequence{};  ///< that the frames show; nothing where not said
  std::optional<Scanner> scanner{};    ///< of the camera that takes them; nothing where not known
  /// Three frames are the channels of a picture in colour, as they were taken: frames 3 n to
  /// 3 n + 2 those of picture n, see colour_channels.h.
  bool in_colour = false;
  FrameSet white{};  ///< in colour: the channels of a white picture, see unmixed; none without one
};

/// Whether there is a file of that name that begins as a recording does.
bool is_recording(const std::filesystem::path& path);

/// Writes frames without loss, one behind another. What is on the disk can be read at any time up
/// to the last whole frame, however the writing ends. A file that was there before stays until the
/// new one is whole, which has a temporary name until then.
class RecordingWriter {
 public:
  /// Throws Error where the header is not valid, WorldError where the file cannot be made; nothing
  /// is left behind then.
  RecordingWriter(const std::filesystem::path& path, const RecordingHeader& header,
                  OutputFile::Writing writing = OutputFile::Writing::over_time);
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;
  /// Closes the file. Without finish() one written over time reads as interrupted if it holds a
  /// frame; else what was there before stays.
  ~RecordingWriter();

  /// Throws Error where the frame is of another format than the header's, WorldError where it
  /// cannot be written: a file written over time then ends with the frame before, and is closed;
  /// the error says how many frames are sure to be on the disk. With none, or written at once, what
  /// was there before stays.
  void append(const Frame& frame);
  /// Marks the end and closes the file; where no frame came, what was there before stays. Throws
  /// WorldError where that fails.
  void finish();
  /// Frames in the file.
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  void write(std::initializer_list<std::span<const std::uint8_t>> parts);
  [[noreturn]] void give_up();
  /// Where it ends before its end.
  [[nodiscard]] bool keeps_frames() const {
    return count_ > 0 && writing_ == OutputFile::Writing::over_time;
  }

  std::filesystem::path path_;
  std::unique_ptr<OutputFile> file_;  ///< none once closed
  OutputFile::Writing writing_;
  FrameFormat format_;
  std::uint64_t header_size_ = 0;
  std::uint64_t count_ = 0;
  std::chrono::steady_clock::time_point first_host_time_;
};

/// Reads what RecordingWriter wrote, any frame at any time.
class RecordingReader {
 public:
  /// Throws Error, naming the file, when it is missing, no recording, or has a damaged header. One
  /// that was interrupted opens up to its last whole frame.
  explicit RecordingReader(const std::filesystem::path& path);

  [[nodiscard]] const RecordingHeader& header() const { return header_; }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// Whether the recording was ended by finish().
  [[nodiscard]] bool finished() const { return finished_; }
  /// Frames at the end of an interrupted recording that are not whole and are left out. Where the
  /// last 256 MiB hold none that is whole, those before are searched by halves.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

  /// Reads frame `index` (below count()) into `frame`, whose memory is used where it is of the
  /// format; its host time is counted from the first frame's. False where its checksum does not
  /// agree: the frame holds nothing to be used then.
  bool read(std::uint64_t index, Frame& frame) const;

  /// Of the header and the frames from `first` up to `end`, that not among them, behind `before`:
  /// by the checksum that each has of its pixels, which are not read.
  [[nodiscard]] std::uint32_t checksum(std::uint64_t first, std::uint64_t end,
                                       std::uint32_t before) const;

 private:
  /// Returns the texts of the scan and of the scanner.
  std::pair<std::string, std::string> read_header();
  void find_end();

  std::filesystem::path path_;
  InputFile file_;
  std::uint64_t header_size_ = 0;
  std::uint32_t header_checksum_ = 0;
  RecordingHeader header_;
  std::uint64_t count_ = 0;
  std::uint64_t dropped_ = 0;
  bool finished_ = false;
};

/// The frames of the first whole cycle of a recording that shows that sequence, in pattern order as
/// PatternWindows puts them. None where none of its first cycles is whole.
std::optional<FrameSet> first_cycle(const RecordingReader& recording, const Sequence& sequence);

/// Windows of a recording that shows that sequence: whole cycles one behind another, counted from
/// the first pattern on, with frames of motion the cycles that have those after them.
std::uint64_t window_count(const RecordingReader& recording, const Sequence& sequence);

/// The frames of a window, below window_count, in pattern order; none where no whole cycle begins
/// there, for frames are lost or damaged.
std::optional<FrameSet> window_at(const RecordingReader& recording, const Sequence& sequence,
                                  std::uint64_t window);

/// RecordingReader::checksum of the frames that window_at, or without a window first_cycle, looks
/// at.
std::uint32_t cycle_checksum(const RecordingReader& recording, const Sequence& sequence,
                             std::optional<std::uint64_t> window, std::uint32_t before);

/// The frames of a scan as a camera gives them, stamped with their places in it. Throws Error,
/// calling the scan `name`, where no camera gives such frames.
std::vector<Frame> frames_of(const FrameViews& scan, const std::string& name);

}  // namespace slipstream
