#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "slipstream/frames/pool.h"
#include "slipstream/io/recording.h"

namespace slipstream {

/// Records on its own thread: record() never waits for the disk. If the disk is full, the recording
/// ends with an error; further frames are discarded.
class Recorder {
 public:
  /// Memory of the frames that may wait for the disk; at least 8 and at most 1024 frames.
  static constexpr std::size_t default_memory = 256 << 20;

  /// Throws as RecordingWriter.
  Recorder(const std::filesystem::path& path, const RecordingHeader& header,
           std::size_t memory = default_memory);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  ~Recorder();  ///< finishes; ignores errors

  /// Copies a frame of the header's format into the queue. Call from one thread. If the queue is
  /// full, waits up to `patience`. Returns false if the frame is discarded: the queue stayed full,
  /// or the recording has ended.
  bool record(const Frame& frame,
              std::chrono::milliseconds patience = std::chrono::milliseconds(0));
  /// Writes the queued frames, marks the end and closes the file. Throws WorldError if the
  /// recording fails or has failed before.
  void finish();

  struct Counts {
    std::uint64_t written = 0;
    std::uint64_t lost = 0;  ///< discarded because the queue was full; leave gaps
  };
  [[nodiscard]] Counts counts() const;
  /// Why the recording ended, one line; empty while it runs or after finish().
  [[nodiscard]] std::string error() const;

 private:
  void write_all();

  RecordingWriter writer_;
  Pool<Frame> pool_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< frames are queued, or the recording has ended
  std::condition_variable room_;     ///< a frame was written, or the recording has ended
  std::vector<Pooled<Frame>> waiting_;
  Counts counts_;
  std::string error_;
  bool ended_ = false;  ///< no more frames are accepted
  std::thread thread_;
};

/// Records the frames of a started source until `ends` returns true, the source ends or the
/// recording fails; returns their number. Calls `taken` after each frame, and `told` when
/// FrameSource::state changes.
std::int64_t record_frames(FrameSource& source, Recorder& recorder,
                           const std::function<bool(std::int64_t frames)>& ends,
                           const std::function<void()>& taken,
                           const std::function<void(const std::string& state)>& told);

/// A source whose frames can be recorded at any time while they pass through. If a recording fails,
/// it ends, and frames keep coming.
class RecordedSource : public FrameSource {
 public:
  /// `header`: of future recordings, with the source's format.
  RecordedSource(std::unique_ptr<FrameSource> source, RecordingHeader header);

  /// Sets the strategy of future recordings, if their header has a sequence. From any thread.
  void set_strategy(const Strategy& strategy);
  /// Records from the next frame on, after finishing a running recording. From any thread. Throws
  /// as Recorder.
  void record_to(const std::filesystem::path& path);
  /// Finishes the recording, if any. From any thread. Throws WorldError if it has failed.
  void finish_recording();

  struct Recording {
    std::filesystem::path path;
    Recorder::Counts counts;
    std::string error;  ///< why it ended; empty while it runs
  };
  /// The running recording, or a failed one that is not yet finished. From any thread.
  [[nodiscard]] std::optional<Recording> recording() const;

  [[nodiscard]] FrameFormat format() const override { return source_->format(); }
  [[nodiscard]] bool has_own_pace() const override { return source_->has_own_pace(); }
  void start() override { source_->start(); }
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override { source_->stop(); }
  void trigger() override { source_->trigger(); }
  [[nodiscard]] SourceCounters counters() const override { return source_->counters(); }
  CameraControls* controls() override { return source_->controls(); }
  /// The source's state; if that is empty, why a recording failed.
  [[nodiscard]] std::string state() const override;

 private:
  [[nodiscard]] std::shared_ptr<Recorder> recorder() const;

  std::unique_ptr<FrameSource> source_;
  mutable std::mutex mutex_;  ///< guards all members below
  RecordingHeader header_;
  std::filesystem::path path_;
  std::shared_ptr<Recorder> recorder_;
};

/// "scan.slip, 120 frames, 3 lost", or why it ended.
std::string text_of(const RecordedSource::Recording& recording);

}  // namespace slipstream
