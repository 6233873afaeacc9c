#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "slipstream/frames/frame.h"
#include "slipstream/frames/frame_source.h"
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

}  // namespace slipstream
