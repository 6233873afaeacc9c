#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "slipstream/frame_source.h"
#include "slipstream/recording.h"

namespace slipstream {

/// Applies a limit to one file, which begins now.
class LimitedFile {
 public:
  LimitedFile(const std::filesystem::path& path, const FileLimit& limit);

  /// Whether `bytes` exceed the limit, or the time is over.
  [[nodiscard]] bool is_full(std::uint64_t bytes) const;

  /// Renames the complete file and returns true if a new one is to begin. Throws if that fails.
  bool goes_on();

  /// "scan.slip: limit reached, recording stopped".
  [[nodiscard]] std::string message() const;

  const std::filesystem::path path;

 private:
  std::filesystem::path before_;
  FileLimit limit_;  ///< of one file
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

/// Records on its own thread: record() never waits for the disk. If the disk is full, the recording
/// ends with an error; further frames are discarded.
class Recorder {
 public:
  /// Memory of the frames that may wait for the disk; at least 8 and at most 1024 frames.
  static constexpr std::size_t default_memory = 256 << 20;

  /// Throws as RecordingWriter.
  Recorder(const std::filesystem::path& path, const RecordingHeader& header,
           std::size_t memory = default_memory, const FileLimit& limit = {});

  ~Recorder();  ///< finishes; ignores errors

  /// Copies a frame of the header's format into the queue. Call from one thread. If the queue is
  /// full, waits up to `patience`. Returns false if the frame is discarded: the queue stayed full,
  /// or the recording has ended.
  bool record(const Frame& frame,
              std::chrono::milliseconds patience = std::chrono::milliseconds(0));

  /// Writes the queued frames, marks the end and closes the file. Throws WorldError if the
  /// recording fails or has failed before.
  void finish();

  struct Status {
    std::uint64_t written = 0;
    std::uint64_t lost = 0;  ///< discarded because the queue was full; leave gaps
    std::string error{};     ///< why it failed, one line; empty if it runs or was finished
    std::string limited{};   ///< LimitedFile::message once the limit has been reached
    bool ended = false;      ///< takes no more frames
  };
  [[nodiscard]] Status status() const;

 private:
  void write_all();
  bool end_at_limit();

  LimitedFile file_;
  const RecordingHeader header_;
  std::optional<RecordingWriter> writer_;  ///< nullopt after the limit

  Pool<Frame> pool_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< frames are queued, or the recording has ended
  std::condition_variable room_;     ///< a frame was written, or the recording has ended

  std::vector<Pooled<Frame>> waiting_;
  Status status_;
  std::thread thread_;
};

/// Records the frames of a started source until `ends` returns true, the source ends or the
/// recording ends by failure or limit; returns their number. Calls `taken` after each frame, and
/// `on_state` when FrameSource::state changes.
std::int64_t record_frames(FrameSource& source, Recorder& recorder,
                           const std::function<bool(std::int64_t frames)>& ends,
                           const std::function<void()>& taken,
                           const std::function<void(const std::string& state)>& on_state);

/// A source whose frames can be recorded at any time while they pass through. If a recording fails
/// or reaches its limit, it ends, and frames keep coming.
class RecordedSource : public SourceOver {
 public:
  /// `header`, `limit`: of future recordings; the header gets the source's format, and as each
  /// begins its camera's temperatures.
  RecordedSource(std::unique_ptr<FrameSource> source, RecordingHeader header,
                 const FileLimit& limit = {});

  /// Sets the strategy of future recordings, if their header has a sequence. From any thread.
  void set_strategy(const Strategy& strategy);

  /// Records from the next frame on, after finishing a running recording. From any thread. Throws
  /// as Recorder.
  void record_to(const std::filesystem::path& path);

  /// Finishes the recording, if any. From any thread. Throws WorldError if it has failed.
  void finish_recording();

  struct Recording : Recorder::Status {
    std::filesystem::path path;
  };
  /// The running recording, or one that has ended and is not yet finished. From any thread.
  [[nodiscard]] std::optional<Recording> recording() const;

  [[nodiscard]] FrameFormat format() const override { return source_->format(); }
  void start() override { source_->start(); }
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  /// The source's state; if that is empty, why a recording failed.
  [[nodiscard]] std::string state() const override;

 private:
  /// Copy of a member that the mutex guards.
  template <class Value>
  [[nodiscard]] Value locked(const Value& value) const {
    const std::lock_guard lock(mutex_);
    return value;
  }

  const FileLimit limit_;
  mutable std::mutex mutex_;  ///< guards all members below
  RecordingHeader header_;
  std::filesystem::path path_;
  std::shared_ptr<Recorder> recorder_;
};

/// "scan.slip, 120 frames, 3 lost", or why it ended.
std::string text_of(const RecordedSource::Recording& recording);

}  // namespace slipstream
