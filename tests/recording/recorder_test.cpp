#include "io/recorder.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/replay_source.h"
#include "slipstream/error.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/recording.h"
#include "tests/io/small_disk.h"
#include "tests/io/temporary_folder.h"
#include "tests/recording/recorded_frames.h"

namespace slipstream::recorder_test {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

TEST(Recorder, WritesEveryFrameThatItTook) {
  const TemporaryFolder folder;
  Recorder recorder(folder.path() / "frames", {.format = some_format});
  std::vector<int> taken;
  for (int i = 0; i < 2000; ++i) {
    if (recorder.record(some_frame(i))) taken.push_back(i);
  }
  recorder.finish();
  EXPECT_EQ(recorder.status().written, taken.size());
  EXPECT_EQ(recorder.status().written + recorder.status().lost, 2000U);
  EXPECT_FALSE(recorder.record(some_frame(0)));

  const RecordingReader reader(folder.path() / "frames");
  EXPECT_TRUE(reader.finished());
  ASSERT_EQ(reader.count(), taken.size());
  Frame frame;
  for (std::uint64_t i = 0; i < reader.count(); ++i) {
    ASSERT_TRUE(reader.read(i, frame));
    EXPECT_TRUE(same_pixels(frame, some_frame(taken[i])));
  }
}

TEST(Recorder, LosesNothingOfWhoWaitsForRoom) {
  const TemporaryFolder folder;
  Recorder recorder(folder.path() / "frames", {.format = some_format}, 0);
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(recorder.record(some_frame(i), 10s));
  recorder.finish();
  EXPECT_EQ(recorder.status().written, 500U);
  EXPECT_EQ(recorder.status().lost, 0U);
}

TEST(Recorder, FinishesWhenItGoes) {
  const TemporaryFolder folder;
  {
    Recorder recorder(folder.path() / "frames", {.format = some_format});
    recorder.record(some_frame(0));
  }
  const RecordingReader reader(folder.path() / "frames");
  EXPECT_TRUE(reader.finished());
  EXPECT_EQ(reader.count(), 1U);
}

TEST(Recorder, FullDiskEndsTheRecordingAndIsToldOnce) {
  const TemporaryFolder folder;
  Recorder recorder(folder.path() / "frames", {.format = some_format});
  const SmallDisk disk(2000);
  while (recorder.status().error.empty()) recorder.record(some_frame(0));
  EXPECT_FALSE(recorder.record(some_frame(0)));
  EXPECT_NE(recorder.status().error.find("the 5 frames before are recorded"), std::string::npos)
      << recorder.status().error;
  EXPECT_THROW(recorder.finish(), WorldError);
  EXPECT_EQ(recorder.status().written, 5U);
  EXPECT_EQ(RecordingReader(folder.path() / "frames").count(), 5U);
}

TEST(Recorder, FileLimitReadsSizesTimesAndRing) {
  EXPECT_EQ(file_limit_from("500MB").bytes, 500'000'000U);
  EXPECT_EQ(file_limit_from("0.5TB,ring").bytes, 500'000'000'000U);
  EXPECT_TRUE(file_limit_from("0.5TB,ring").ring);
  EXPECT_EQ(file_limit_from("2GB").seconds, std::numeric_limits<double>::infinity());
  EXPECT_EQ(file_limit_from("90s").seconds, 90);
  EXPECT_EQ(file_limit_from("10min").bytes, no_limit);
  EXPECT_EQ(file_limit_from("2h").seconds, 7200);
  for (const char* text : {"", "ring", "2", "GB", "-2GB", "0s", "2gb", "2GB,", "2 GB", "nans",
                           "1e9TB", "2GB;ring", "9999999h", "2GB,rings"}) {
    EXPECT_THROW(file_limit_from(text), Error) << text;
  }
}

TEST(Recorder, StopsAtItsLimit) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.slip";
  constexpr std::uint64_t most = 4000;
  Recorder recorder(path, {.format = some_format}, 0, {.bytes = most});
  while (recorder.record(some_frame(0), 10s)) continue;
  EXPECT_TRUE(recorder.status().ended);
  EXPECT_EQ(recorder.status().error, "");
  EXPECT_NE(recorder.status().limited.find("a.slip: limit reached, recording stopped"),
            std::string::npos);
  recorder.finish();
  const RecordingReader reader(path);
  EXPECT_TRUE(reader.finished());
  EXPECT_EQ(reader.count(), recorder.status().written);
  EXPECT_LE(fs::file_size(path), most);
  EXPECT_GT(fs::file_size(path), most - 400) << "one frame less than the limit";
}

TEST(Recorder, RingKeepsTheNewestFrames) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.slip", before = folder.path() / "a-before-2.slip";
  std::ofstream(folder.path() / "a-before.slip") << "of another run";
  constexpr std::uint64_t most = 8000;
  Recorder recorder(path, {.format = some_format}, 0, {.bytes = most, .ring = true});
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(recorder.record(some_frame(i), 10s));
  recorder.finish();
  EXPECT_EQ(recorder.status().written, 100U);
  EXPECT_NE(recorder.status().limited.find("a-before-2.slip"), std::string::npos)
      << recorder.status().limited;
  EXPECT_EQ(fs::file_size(folder.path() / "a-before.slip"), 14U);
  EXPECT_LE(fs::file_size(path) + fs::file_size(before), most);
  std::vector<std::uint64_t> kept;
  for (const fs::path& file : {before, path}) {
    const RecordingReader reader(file);
    EXPECT_TRUE(reader.finished());
    Frame frame;
    for (std::uint64_t i = 0; i < reader.count(); ++i) {
      ASSERT_TRUE(reader.read(i, frame));
      kept.push_back(frame.stamp.sequence);
    }
  }
  ASSERT_GE(kept.size(), 10U);
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i], 100 - kept.size() + i);
}

/// An endless source that loops a recording of `count` frames.
std::unique_ptr<FrameSource> some_source(const fs::path& path, int count) {
  RecordingWriter writer(path, {.format = some_format});
  for (int i = 0; i < count; ++i) writer.append(some_frame(i));
  writer.finish();
  return std::make_unique<ReplaySource>(path, ReplaySettings{.rate = 0.0, .loop = true});
}

TEST(Recorder, RecordedSourceRecordsWhatPassesBetweenBeginningAndEnd) {
  const TemporaryFolder folder;
  RecordedSource source(some_source(folder.path() / "played", 16), {});
  source.start();
  Frame frame(source.format());
  const auto pass = [&](int count) {
    for (int i = 0; i < count; ++i) ASSERT_EQ(source.next(frame, 10ms), Arrival::frame);
  };
  pass(3);
  EXPECT_FALSE(source.recording());
  source.record_to(folder.path() / "first");
  pass(4);
  EXPECT_EQ(source.recording()->path, folder.path() / "first");
  source.record_to(folder.path() / "second");
  pass(5);
  source.finish_recording();
  source.finish_recording();
  pass(2);
  const RecordingReader first(folder.path() / "first"), second(folder.path() / "second");
  EXPECT_EQ(first.count(), 4U);
  EXPECT_EQ(second.count(), 5U);
  ASSERT_TRUE(second.read(0, frame));
  EXPECT_EQ(frame.stamp.sequence, 7U);
}

TEST(Recorder, RecordedSourceGoesOnAfterTheLimit) {
  const TemporaryFolder folder;
  RecordedSource source(some_source(folder.path() / "played", 16), {}, {.seconds = 0.001});
  source.start();
  source.record_to(folder.path() / "first");
  Frame frame(source.format());
  while (source.recording()->limited.empty()) {
    ASSERT_EQ(source.next(frame, 10ms), Arrival::frame);
    std::this_thread::sleep_for(1ms);
  }
  ASSERT_EQ(source.next(frame, 10ms), Arrival::frame);
  EXPECT_EQ(source.state(), "");
  EXPECT_NE(text_of(*source.recording()).find("limit reached"), std::string::npos);
  source.finish_recording();
  EXPECT_TRUE(RecordingReader(folder.path() / "first").finished());
}

TEST(Recorder, RecordedSourceRecordingsNameTheStrategyThatIsShownWhenTheyBegin) {
  const TemporaryFolder folder;
  RecordedSource source(some_source(folder.path() / "played", 16),
                        {.sequence = Sequence{.strategy = PhaseMeasuring{.steps = 4}}});
  source.start();
  Frame frame(source.format());
  source.record_to(folder.path() / "first");
  source.set_strategy(PhaseMeasuring{.steps = 6});
  ASSERT_EQ(source.next(frame, 10ms), Arrival::frame);
  source.record_to(folder.path() / "second");
  ASSERT_EQ(source.next(frame, 10ms), Arrival::frame);
  source.finish_recording();
  const auto steps = [&](const char* name) {
    const RecordingReader reader(folder.path() / name);
    return frame_count(reader.header().sequence->strategy);
  };
  EXPECT_EQ(steps("first"), 4);
  EXPECT_EQ(steps("second"), 6);
}

TEST(Recorder, RecordedSourceKeepsGivingFramesWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  RecordedSource source(some_source(folder.path() / "played", 16), {});
  source.start();
  source.record_to(folder.path() / "frames");
  const SmallDisk disk(2000);
  Frame frame(source.format());
  while (source.state().empty()) ASSERT_EQ(source.next(frame, 10ms), Arrival::frame);
  EXPECT_NE(source.state().find("cannot write"), std::string::npos);
  EXPECT_EQ(source.recording()->error, source.state());
  for (int i = 0; i < 100; ++i) ASSERT_EQ(source.next(frame, 10ms), Arrival::frame);
  EXPECT_THROW(source.finish_recording(), WorldError);
  EXPECT_EQ(source.state(), "");
  EXPECT_EQ(RecordingReader(folder.path() / "frames").count(), 5U);
}

TEST(Recorder, RecordedSourceRecordingsComeAndGoWhileFramesPass) {
  const TemporaryFolder folder;
  RecordedSource source(some_source(folder.path() / "played", 16), {});
  source.start();
  std::jthread capture([&](const std::stop_token& stop) {
    for (Frame frame(source.format()); !stop.stop_requested();) (void)source.next(frame, 10ms);
  });
  for (int i = 0; i < 20; ++i) {
    const fs::path path = folder.path() / std::to_string(i);
    source.record_to(path);
    while (source.recording()->written < 3) std::this_thread::yield();
    source.finish_recording();
    EXPECT_TRUE(RecordingReader(path).finished());
  }
}

}  // namespace slipstream::recorder_test
