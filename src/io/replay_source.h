#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/scan_folder.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"

namespace slipstream {

/// Pace and repetition of a replay.
struct ReplaySettings {
  /// Frames (in colour: pictures) per second; 0: as fast as requested; nullopt: at the recorded
  /// times, or as fast as requested for a scan folder and for frames recorded from memory, at more
  /// than 5,000 per second.
  std::optional<double> rate;
  bool loop = false;   ///< restarts at the end
  ScanChanges scan{};  ///< overrides a scan folder's settings
};

/// Replays a recording, a scan folder or a folder of many grey frames as if a camera delivered the
/// frames now. Missing frames leave the same gaps in the sequence. In a loop, the sequence
/// continues without a gap: each round has complete cycles, so that frame counting still gives the
/// pattern. Colour pictures arrive as channels, as in RecordingHeader, also from a scan folder.
class ReplaySource : public FrameSource {
 public:
  /// Throws Error if `path` is neither a recording nor a scan folder, has no readable frame, or the
  /// rate is out of range.
  ReplaySource(const std::filesystem::path& path, const ReplaySettings& settings);

  /// Format, strategy and scanner of the recording or folder.
  [[nodiscard]] const RecordingHeader& header() const { return header_; }

  /// Colours of a folder of one cycle, see Scan::colour; otherwise empty.
  [[nodiscard]] const Image<Colour>& colour() const { return colour_; }

  /// "PATH: was interrupted; ..." if the recording is incomplete; otherwise empty.
  [[nodiscard]] const std::string& warning() const { return warning_; }

  [[nodiscard]] FrameFormat format() const override { return header_.format; }
  [[nodiscard]] bool has_own_pace() const override { return paced_; }

  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override {}

  [[nodiscard]] SourceCounters counters() const override {
    return {.delivered = delivered_, .lost = damaged_};
  }

  [[nodiscard]] std::string state() const override { return {}; }

 private:
  void open_recording(const std::filesystem::path& path);
  void open_folder(const std::filesystem::path& folder);
  void open_pictures(const ScanFiles& files);
  void measure_round(const std::filesystem::path& path);

  /// Frame `index` with its original stamp; returns false if it is damaged.
  bool read(std::uint64_t index, Frame& frame) const;

  /// Reads the next frame into `ahead_`, stamped for this round; returns false at the end.
  bool read_ahead();

  [[nodiscard]] std::chrono::steady_clock::time_point due() const;

  ReplaySettings settings_;
  RecordingHeader header_;
  std::string warning_;
  bool paced_ = false;

  std::unique_ptr<RecordingReader> reader_;
  std::vector<Frame> frames_;                    ///< of a scan folder of one cycle
  std::vector<std::filesystem::path> pictures_;  ///< of a folder of more, read when due
  int bits_ = 0;                                 ///< of these
  GreyChannel channel_ = GreyChannel::by_light;  ///< of these, if in colour
  std::string mosaic_;                           ///< of these, if raw
  Image<Colour> colour_;
  std::uint64_t count_ = 0;

  /// Increments of the stamps from one round to the next.
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
  bool is_ahead_ = false;   ///< `ahead_` has been read but not delivered
  bool ahead_is_whole_ = false;
  Frame ahead_;
  std::atomic<std::uint64_t> delivered_ = 0;
  std::atomic<std::uint64_t> damaged_ = 0;
};

}  // namespace slipstream
