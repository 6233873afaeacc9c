#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "slipstream/frames/frame_source.h"
#include "slipstream/io/recorder.h"

namespace slipstream {

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
