#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "slipstream/frames/pool.h"
#include "slipstream/io/recording.h"

namespace slipstream {

/// Records on a thread of its own: who hands frames in never waits for the disk. When the disk is
/// full the recording ends there and says so; frames may still be handed in, and are not kept.
class Recorder {
 public:
  /// As many frames as take that much memory may wait for the disk; 8 at least, 1024 at most.
  static constexpr std::size_t default_memory = 256 << 20;

  /// Throws as RecordingWriter.
  Recorder(const std::filesystem::path& path, const RecordingHeader& header,
           std::size_t memory = default_memory);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  ~Recorder();  ///< finishes; an error is lost then

  /// Copies the frame, which has the header's format, into the queue. One thread calls it. Where
  /// the queue is full it waits for room, `patience` at most. False where the frame is not kept: no
  /// room came, or the recording has ended.
  bool record(const Frame& frame,
              std::chrono::milliseconds patience = std::chrono::milliseconds(0));
  /// Writes what waits, marks the end and closes the file. Throws WorldError where the recording
  /// has failed, then or before.
  void finish();

  struct Counts {
    std::uint64_t written = 0;
    std::uint64_t lost = 0;  ///< the queue was full: the recording has a gap there
  };
  [[nodiscard]] Counts counts() const;
  /// Why the recording ended, one line; empty while it goes on or where it was finished.
  [[nodiscard]] std::string error() const;

 private:
  void write_all();

  RecordingWriter writer_;
  Pool<Frame> pool_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< frames wait, or it has ended
  std::condition_variable room_;     ///< a frame was written, or it has ended
  std::vector<Pooled<Frame>> waiting_;
  Counts counts_;
  std::string error_;
  bool ended_ = false;  ///< no more frames are taken
  std::thread thread_;
};

/// Hands the frames of a source that has been started to a recorder until `ends` says so, the
/// source ends or the recording fails; returns how many. `taken` is called after each frame, `told`
/// when FrameSource::state changes.
std::int64_t record_frames(FrameSource& source, Recorder& recorder,
                           const std::function<bool(std::int64_t frames)>& ends,
                           const std::function<void()>& taken,
                           const std::function<void(const std::string& state)>& told);

/// A source whose frames can be recorded as they pass, at any time. A recording that fails ends;
/// the frames keep coming.
class RecordedSource : public FrameSource {
 public:
  /// `header`: of the recordings to come; its format is the source's.
  RecordedSource(std::unique_ptr<FrameSource> source, RecordingHeader header);

  /// The frames show this strategy from now on: of the recordings to come, where their header says
  /// what is shown. From any thread.
  void set_strategy(const Strategy& strategy);
  /// Records from the next frame on; a recording under way is finished first. From any thread.
  /// Throws as Recorder.
  void record_to(const std::filesystem::path& path);
  /// Finishes the recording, if there is one. From any thread. Throws WorldError where it has
  /// failed.
  void finish_recording();

  struct Recording {
    std::filesystem::path path;
    Recorder::Counts counts;
    std::string error;  ///< why it ended; empty while it goes on
  };
  /// The one under way, or the one that has failed and is not finished yet. From any thread.
  [[nodiscard]] std::optional<Recording> recording() const;

  [[nodiscard]] FrameFormat format() const override { return source_->format(); }
  [[nodiscard]] bool has_own_pace() const override { return source_->has_own_pace(); }
  void start() override { source_->start(); }
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override { source_->stop(); }
  void trigger() override { source_->trigger(); }
  [[nodiscard]] SourceCounters counters() const override { return source_->counters(); }
  CameraControls* controls() override { return source_->controls(); }
  /// The source's; where it has nothing to say, why a recording has failed.
  [[nodiscard]] std::string state() const override;

 private:
  [[nodiscard]] std::shared_ptr<Recorder> recorder() const;

  std::unique_ptr<FrameSource> source_;
  mutable std::mutex mutex_;  ///< of all that follow
  RecordingHeader header_;
  std::filesystem::path path_;
  std::shared_ptr<Recorder> recorder_;
};

/// "scan.slip, 120 frames, 3 lost", or why it ended.
std::string text_of(const RecordedSource::Recording& recording);

}  // namespace slipstream
