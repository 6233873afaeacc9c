#pragma once

#include <atomic>

#include "slipstream/io/recording.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream {

/// How fast recorded frames come, and whether they come again.
struct ReplaySettings {
  /// Frames per second, in colour pictures; 0: as fast as they are asked for; none: at the times of
  /// the recording. A scan folder has no times, nor have frames recorded from memory at more than
  /// 5,000 per second: they are read as fast as they are asked for.
  std::optional<double> rate;
  bool loop = false;   ///< begins again at the end
  ScanChanges scan{};  ///< over what a scan folder says
};

/// The frames of a recording or of a scan folder, as if a camera took them now. What the recording
/// lacks is a gap in the sequence, as it was then. Looped, the sequence goes on without a gap: each
/// round is of whole cycles, so that the pattern of each frame can be counted as before. Pictures
/// in colour come as their channels, as RecordingHeader has them, from a scan folder too.
class ReplaySource : public FrameSource {
 public:
  /// Throws Error where `path` is neither a recording nor a scan folder, has no frame that can be
  /// read, or the rate is out of range.
  ReplaySource(const std::filesystem::path& path, const ReplaySettings& settings);

  /// What the recording or the folder says of its frames: format, strategy, scanner.
  [[nodiscard]] const RecordingHeader& header() const { return header_; }
  /// For people: "PATH: was interrupted; ..." where the recording is not whole; else empty.
  [[nodiscard]] const std::string& warning() const { return warning_; }

  [[nodiscard]] FrameFormat format() const override { return header_.format; }
  [[nodiscard]] bool has_own_pace() const override { return paced_; }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override;
  [[nodiscard]] std::string state() const override { return {}; }

 private:
  void open_recording(const std::filesystem::path& path);
  void open_folder(const std::filesystem::path& folder);
  void measure_round(const std::filesystem::path& path);
  /// Frame `index` as it was stamped then; false where it is damaged.
  bool read(std::uint64_t index, Frame& frame) const;
  /// Reads the next frame into `ahead_`, stamped as if taken in this round; false at the end.
  bool read_ahead();
  [[nodiscard]] std::chrono::steady_clock::time_point due() const;

  ReplaySettings settings_;
  RecordingHeader header_;
  std::string warning_;
  bool paced_ = false;
  std::unique_ptr<RecordingReader> reader_;
  std::vector<Frame> frames_;  ///< of a scan folder
  std::uint64_t count_ = 0;

  /// What is added to the stamps of a frame from one round to the next.
  struct Round {
    std::uint64_t sequence = 0;
    std::chrono::nanoseconds device_time{};
    std::chrono::nanoseconds host_time{};
  };
  Round round_;
  std::uint64_t first_sequence_ = 0;  ///< a multiple of N
  std::chrono::steady_clock::time_point first_host_time_;

  std::chrono::steady_clock::time_point started_;
  std::uint64_t next_ = 0;  ///< frames read since the start, in all rounds
  bool is_ahead_ = false;   ///< `ahead_` has been read and not been given out
  bool ahead_is_whole_ = false;
  Frame ahead_;
  std::atomic<std::uint64_t> delivered_ = 0;
  std::atomic<std::uint64_t> damaged_ = 0;
};

}  // namespace slipstream
