#include "io/replay_source.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "frames/pattern_windows.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/scan_folder.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"
#include "tests/recording/recorded_frames.h"

namespace slipstream::replay_source_test {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// Records frames with these numbers, PMP with N = 4.
void record(const fs::path& path, const std::vector<int>& numbers) {
  RecordingWriter writer(
      path, {.format = some_format, .sequence = Sequence{.strategy = PhaseMeasuring{.steps = 4}}});
  for (const int number : numbers) writer.append(some_frame(number));
  writer.finish();
}

TEST(ReplaySource, GivesTheFramesInOrderAndEnds) {
  const TemporaryFolder folder;
  record(folder.path() / "frames", {0, 1, 2, 3, 4});
  ReplaySource source(folder.path() / "frames", {.rate = 0.0});
  EXPECT_EQ(source.format(), some_format);
  EXPECT_FALSE(source.has_own_pace());
  EXPECT_EQ(source.warning(), "");
  for (int start = 0; start < 2; ++start) {
    source.start();
    Frame frame(source.format());
    for (int i = 0; i < 5; ++i) {
      ASSERT_EQ(source.next(frame, 0ms), Arrival::frame);
      EXPECT_TRUE(same_pixels(frame, some_frame(i)));
      EXPECT_EQ(frame.stamp.sequence, static_cast<std::uint64_t>(i));
      EXPECT_EQ(frame.stamp.pattern_index, i % 4);
      EXPECT_LE(frame.stamp.host_time, std::chrono::steady_clock::now());
    }
    EXPECT_EQ(source.next(frame, 0ms), Arrival::ended);
    source.stop();
  }
  EXPECT_EQ(source.counters().delivered, 10U);
}

TEST(ReplaySource, KeepsGapsAndTheCountOfPatternsWhenItBeginsAgain) {
  const TemporaryFolder folder;
  record(folder.path() / "frames", {6, 7, 9, 10, 11});
  ReplaySource source(folder.path() / "frames", {.rate = 0.0, .loop = true});
  source.start();
  Frame frame(source.format());
  std::vector<std::uint64_t> sequences;
  for (int i = 0; i < 12; ++i) {
    ASSERT_EQ(source.next(frame, 0ms), Arrival::frame);
    sequences.push_back(frame.stamp.sequence);
    EXPECT_EQ(frame.stamp.sequence % 4, static_cast<std::uint64_t>(*frame.stamp.pattern_index));
  }
  EXPECT_EQ(sequences, (std::vector<std::uint64_t>{2, 3, 5, 6, 7, 9, 10, 11, 13, 14, 15, 17}));
}

TEST(ReplaySource, LosesNothingWhereItBeginsAgain) {
  for (int first = 0; first < 5; ++first) {
    for (int count = 1; count <= 13; ++count) {
      SCOPED_TRACE(testing::Message() << count << " frames from " << first);
      const TemporaryFolder folder;
      std::vector<int> numbers(static_cast<std::size_t>(count));
      std::iota(numbers.begin(), numbers.end(), first);
      record(folder.path() / "frames", numbers);
      ReplaySource source(folder.path() / "frames", {.rate = 0.0, .loop = true});
      source.start();
      Frame frame(source.format());
      ASSERT_EQ(source.next(frame, 0ms), Arrival::frame);
      for (std::uint64_t before = frame.stamp.sequence; before < 40; ++before) {
        ASSERT_EQ(source.next(frame, 0ms), Arrival::frame);
        if (count < 4) break;  // without a whole cycle it cannot loop seamlessly
        ASSERT_EQ(frame.stamp.sequence, before + 1);
        ASSERT_EQ(*frame.stamp.pattern_index, static_cast<int>((before + 1) % 4));
      }
    }
  }
}

TEST(ReplaySource, KeepsTheTimesOfTheRecording) {
  const TemporaryFolder folder;
  record(folder.path() / "frames", {0, 40, 79});  // frame numbers are times in ms
  ReplaySource source(folder.path() / "frames", {.loop = true});
  EXPECT_TRUE(source.has_own_pace());
  source.start();
  const auto start = std::chrono::steady_clock::now();
  Frame frame(source.format());
  EXPECT_EQ(source.next(frame, 1ms), Arrival::frame);
  EXPECT_EQ(source.next(frame, 1ms), Arrival::nothing);
  for (int i = 1; i < 4; ++i) {
    while (source.next(frame, 1ms) == Arrival::nothing) {
    }
    EXPECT_GE(std::chrono::steady_clock::now() - start, i * 39ms);
  }
  EXPECT_EQ(frame.stamp.device_time, 1118500us);
}

TEST(ReplaySource, HasNoPaceWhereFramesCameFromMemory) {
  const TemporaryFolder folder;
  RecordingWriter writer(folder.path() / "frames", {.format = some_format});
  for (int i = 0; i < 40; ++i) {
    Frame frame = some_frame(i);
    frame.stamp.host_time = std::chrono::steady_clock::time_point(i * 20us);
    writer.append(frame);
  }
  writer.finish();
  EXPECT_FALSE(ReplaySource(folder.path() / "frames", {}).has_own_pace());
  EXPECT_TRUE(ReplaySource(folder.path() / "frames", {.rate = 60.0}).has_own_pace());
}

TEST(ReplaySource, ComesAtTheRateAskedFor) {
  const TemporaryFolder folder;
  record(folder.path() / "frames", {0, 1, 2, 3, 4});
  ReplaySource source(folder.path() / "frames", {.rate = 100});
  EXPECT_TRUE(source.has_own_pace());
  source.start();
  const auto start = std::chrono::steady_clock::now();
  Frame frame(source.format());
  for (int i = 0; i < 5; ++i) ASSERT_EQ(source.next(frame, 1000ms), Arrival::frame);
  EXPECT_GE(std::chrono::steady_clock::now() - start, 40ms);
}

TEST(ReplaySource, TellsOfDamagedFrames) {
  const TemporaryFolder folder;
  record(folder.path() / "frames", {0, 1, 2, 3});
  std::vector<std::uint8_t> bytes = read_file(folder.path() / "frames");
  const std::size_t header = RecordingReader(folder.path() / "frames").header().sequence ? 256 : 64;
  bytes[header + 384 + 100] ^= 1;
  write_file(folder.path() / "frames", bytes);
  ReplaySource source(folder.path() / "frames", {});
  source.start();
  Frame frame(source.format());
  int whole = 0;
  Arrival arrival = Arrival::nothing;
  while ((arrival = source.next(frame, 100ms)) != Arrival::ended) {
    if (arrival == Arrival::frame) ++whole;
  }
  EXPECT_EQ(whole, 3);
  EXPECT_EQ(source.counters().lost, 1U);
}

TEST(ReplaySource, SaysThatARecordingWasInterrupted) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  record(path, {0, 1, 2});
  fs::resize_file(path, fs::file_size(path) - 100);
  const ReplaySource source(path, {});
  EXPECT_NE(source.warning().find("2 complete frames, 1 dropped"), std::string::npos)
      << source.warning();
}

TEST(ReplaySource, RefusesWhatCannotBeReplayed) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  expect_error([&] { ReplaySource(path, {}); }, {"no such file"});
  record(path, {0});
  fs::resize_file(path, fs::file_size(path) - 100);
  expect_error([&] { ReplaySource(path, {}); }, {"no complete frame"});
  expect_error([&] { ReplaySource(path, {.rate = -3}); }, {"-3"});
  expect_error([&] { ReplaySource(folder.path(), {}); }, {"no pictures"});
}

/// Writes a scan of the statue with its pictures and scanner file.
FrameSet write_scan(const fs::path& folder, const Scanner& scanner, const Strategy& strategy,
                    int bits) {
  FrameSet frames = take_scan(scanner, scene_named("statue", scanner),
                              pattern_set(strategy, Axis::x), {.bits = bits})
                        .frames;
  save_scan(folder, frames, {.strategy = strategy}, {.scanner = scanner});
  return frames;
}

TEST(ReplaySource, RefusesPicturesOf16BitsThatAreSaidToHave8) {
  const TemporaryFolder folder;
  const Scanner scanner = example_scanner({48, 36});
  const Strategy strategy = PhaseMeasuring{.steps = 4};
  write_scan(folder.path(), scanner, strategy, 12);
  ScanFiles scan = read_scan_files(folder.path() / "scan.yaml");
  scan.bits = 8;
  write_scan_files(folder.path() / "scan.yaml", scan);
  expect_error([&] { ReplaySource(folder.path(), {}); },
               {folder.path().string(), "16-bit pictures", "bits is 8"});
}

TEST(ReplaySource, ReadsSeveralCyclesOfPicturesByTheChannelThatIsChosen) {
  const TemporaryFolder folder;
  for (int n = 0; n < 8; ++n) {
    write_image(folder.path() / ("frame_" + std::to_string(n) + ".png"),
                Image<Colour>({40, 30}, Colour{7, 100, 200}));
  }

  ReplaySettings settings{.rate = 0};
  settings.scan.sequence.strategy = "pmp";
  settings.scan.sequence.settings["steps"] = "4";
  settings.scan.channel = GreyChannel::red;
  ReplaySource source(folder.path(), settings);
  Frame frame(source.format());
  source.start();
  ASSERT_EQ(source.next(frame, 100ms), Arrival::frame);
  EXPECT_EQ(std::get<Image<std::uint8_t>>(frame.pixels)(5, 3), 7);
}

TEST(ReplaySource, GivesTheChannelsOfPicturesInColourFromAFolderAndFromItsRecording) {
  const TemporaryFolder folder;
  Scanner scanner = example_scanner({48, 36});
  const Strategy strategy = PhaseMeasuring{.steps = 3};
  const VirtualScan taken =
      take_colour_scan(scanner, scene_named("board", scanner), pattern_set(strategy, Axis::x), {},
                       {.mixture = usual_mixture});
  scanner.photometry.colour_mixture = usual_mixture;
  for (const char* const name : {"scan", "scan.slip"}) {
    const fs::path path = folder.path() / name;
    save_scan(path, taken.frames, {.strategy = strategy},
              {.scanner = scanner, .in_colour = true, .white = taken.white});
    ReplaySource source(path, {.rate = 0});
    EXPECT_TRUE(source.header().in_colour);
    EXPECT_EQ(source.header().scanner, scanner);
    const auto expect_same = [](const Frame& a, const Frame& b) { EXPECT_TRUE(same_pixels(a, b)); };
    const std::vector<Frame> frames = frames_of(taken.frames, "taken"),
                             white = frames_of(taken.white, "white"),
                             kept = frames_of(source.header().white, "kept");
    ASSERT_EQ(kept.size(), white.size());
    for (std::size_t c = 0; c < white.size(); ++c) expect_same(kept[c], white[c]);
    Frame frame(source.format());
    source.start();
    for (const Frame& wanted : frames) {
      ASSERT_EQ(source.next(frame, 1s), Arrival::frame);
      expect_same(frame, wanted);
    }
    EXPECT_EQ(source.next(frame, 1s), Arrival::ended);
  }
}

template <class Pixel>
FrameViews views_of(const std::vector<Frame>& frames) {
  FrameViews views;
  views.assign<Pixel>(frames, frames[0].bits, [](const Frame& frame) {
    return ImageView<const Pixel>(std::get<Image<Pixel>>(frame.pixels));
  });
  return views;
}

bool same_bits(const Image<float>& a, const Image<float>& b) {
  return a.size() == b.size() &&
         std::memcmp(a.begin(), b.begin(), a.pixel_count() * sizeof(float)) == 0;
}

TEST(ReplaySource, GivesBitIdenticalCloudsFromAScanFolderAndFromItsRecording) {
  const TemporaryFolder folder;
  const Scanner scanner = example_scanner({96, 72});
  const Strategy strategy = DualFrequency{.steps = 3, .high = 16, .low = 1};
  for (const int bits : {8, 12}) {
    const FrameSet frames = write_scan(folder.path(), scanner, strategy, bits);
    Engine engine(scanner, {.strategy = strategy});
    Cloud offline, cloud;
    engine.cloud(frames, offline);

    const fs::path recording = folder.path() / "recording";
    for (const fs::path& path : {folder.path(), recording}) {
      ReplaySource source(path, {});
      EXPECT_EQ(source.format(), (FrameFormat{{96, 72}, bits}));
      EXPECT_EQ(source.header().scanner, scanner);
      RecordingWriter writer(folder.path() / "copy", source.header());
      source.start();
      std::vector<Frame> replayed;
      for (Frame frame(source.format()); source.next(frame, 1000ms) == Arrival::frame;) {
        EXPECT_EQ(frame.stamp.pattern_index, static_cast<int>(replayed.size()));
        writer.append(frame);
        replayed.push_back(frame);
      }
      writer.finish();
      fs::rename(folder.path() / "copy", recording);
      ASSERT_EQ(replayed.size(), 6U);
      engine.cloud(bits == 8 ? views_of<std::uint8_t>(replayed) : views_of<std::uint16_t>(replayed),
                   cloud);
      EXPECT_TRUE(same_bits(cloud.x, offline.x) && same_bits(cloud.y, offline.y) &&
                  same_bits(cloud.z, offline.z) && same_bits(cloud.intensity, offline.intensity))
          << path << ", " << bits << " bits";
    }
  }
}

TEST(ReplaySource, SaysThatItLeavesOutTheOtherAxisOfAScanFolder) {
  const TemporaryFolder folder;
  const Scanner scanner = example_scanner({16, 12});
  Sequence sequence{.strategy = PhaseMeasuring{.steps = 3}, .projector = scanner.projector.size};
  sequence.both_axes = true;
  const Scene scene = scene_named("board", scanner);
  save_scan(folder.path(), take_scan(scanner, scene, pattern_set(sequence)).frames, sequence,
            {.scanner = scanner});

  const ReplaySource source(folder.path(), {});
  EXPECT_EQ(frame_count(source.header().sequence.value()), 3);
  EXPECT_NE(source.warning().find("only its frames along x"), std::string::npos)
      << source.warning();
}

TEST(ReplaySource, RepeatsAScanFolder) {
  const TemporaryFolder folder;
  const Strategy strategy = PhaseMeasuring{.steps = 3};
  write_scan(folder.path(), example_scanner({16, 12}), strategy, 8);
  ReplaySource source(folder.path(), {.rate = 1000, .loop = true});
  source.start();
  Frame frame(source.format());
  for (int i = 0; i < 8; ++i) {
    ASSERT_EQ(source.next(frame, 1000ms), Arrival::frame);
    EXPECT_EQ(frame.stamp.sequence, static_cast<std::uint64_t>(i));
    EXPECT_EQ(frame.stamp.pattern_index, i % 3);
  }
}

}  // namespace slipstream::replay_source_test
