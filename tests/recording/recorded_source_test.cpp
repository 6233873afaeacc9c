// A source over time: after any sequence of steps its state and its recordings are those of a
// model.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "io/file_names.h"
#include "io/recorder.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/recording.h"
#include "slipstream/strategy.h"
#include "tests/io/temporary_folder.h"
#include "tests/recording/recorded_frames.h"
#include "tests/step_sequences.h"

namespace slipstream::recorded_source_test {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr const char* lost = "camera is lost; searching for it";

/// A camera that can be unplugged.
class Camera : public FrameSource {
 public:
  bool is_gone = false;
  int next_number = 0;

  [[nodiscard]] FrameFormat format() const override { return some_format; }
  [[nodiscard]] bool has_own_pace() const override { return true; }
  void start() override {}
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override { return {}; }
  [[nodiscard]] std::string state() const override { return is_gone ? lost : ""; }

  Arrival next(Frame& frame, std::chrono::milliseconds) override {
    if (is_gone) return Arrival::nothing;
    frame = some_frame(next_number++);
    return Arrival::frame;
  }
};

/// What a file must hold.
struct Recorded {
  fs::path path;
  int first = 0;  ///< frame
  int count = 0;
  int steps = 0;  ///< of the strategy
};

class RecordedCamera {
 public:
  RecordedCamera() {
    auto camera = std::make_unique<Camera>();
    camera_ = camera.get();
    source_.emplace(std::move(camera),
                    RecordingHeader{.sequence = Sequence{.strategy = PhaseMeasuring{.steps = 3}}});
    source_->start();
  }

  void take(const std::string& step) {
    if (step == "frames") {
      for (int i = 0; i < 3; ++i) pass();
    }
    if (step == "camera gone") camera_->is_gone = true;
    if (step == "camera back") camera_->is_gone = false;
    if (step == "record") record();
    if (step == "finish") finish();
    if (step == "strategy") source_->set_strategy(PhaseMeasuring{.steps = ++steps_});
    if (step == "restart") {
      source_->stop();
      source_->start();
    }

    RC_ASSERT(source_->state() == (camera_->is_gone ? lost : ""));
    RC_ASSERT(source_->recording().has_value() == is_recording_);
    if (is_recording_) RC_ASSERT(source_->recording()->path == recorded_.back().path);
  }

  /// Compares all files with the model.
  void check_files() {
    finish();
    RC_ASSERT(
        std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()) ==
        std::ranges::count_if(recorded_, [](const Recorded& each) { return each.count > 0; }));

    Frame frame(some_format);
    for (const auto& [path, first, count, steps] : recorded_) {
      if (count == 0) continue;
      const RecordingReader reader(path);
      RC_ASSERT(reader.finished());
      RC_ASSERT(reader.count() == static_cast<std::uint64_t>(count));
      RC_ASSERT(frame_count(reader.header().sequence->strategy) == steps);

      RC_ASSERT(reader.read(0, frame));
      RC_ASSERT(frame.stamp.sequence == static_cast<std::uint64_t>(first));
    }
  }

 private:
  void pass() {
    Frame frame(some_format);
    const Arrival arrival = source_->next(frame, 0ms);
    RC_ASSERT(arrival == (camera_->is_gone ? Arrival::nothing : Arrival::frame));
    if (arrival == Arrival::frame && is_recording_) ++recorded_.back().count;
  }

  /// A second recording ends the first.
  void record() {
    const NewFile file(folder_.path() / "frames.slip");
    source_->record_to(file.path());
    recorded_.push_back({.path = file.path(), .first = camera_->next_number, .steps = steps_});
    is_recording_ = true;
  }

  void finish() {
    source_->finish_recording();
    is_recording_ = false;
  }

  const TemporaryFolder folder_;
  Camera* camera_ = nullptr;  ///< owned by the source
  std::optional<RecordedSource> source_;

  // The model:
  std::vector<Recorded> recorded_;
  bool is_recording_ = false;
  int steps_ = 3;
};

TEST(RecordedSource, IsItsModelAfterAnySequenceOfSteps) {
  check_sequences(
      {"frames", "camera gone", "camera back", "record", "finish", "strategy", "restart"}, 30, 20,
      [](const std::vector<std::string>& steps) {
        RecordedCamera camera;
        for (const std::string& step : steps) camera.take(step);
        camera.check_files();
      });
}

}  // namespace slipstream::recorded_source_test
