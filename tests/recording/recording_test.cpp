#include "slipstream/recording.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "frames/scan_camera.h"
#include "io/file.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "tests/io/expect_error.h"
#include "tests/io/small_disk.h"
#include "tests/io/temporary_folder.h"
#include "tests/recording/recorded_frames.h"

namespace slipstream::recording_test {
namespace fs = std::filesystem;

void record(const fs::path& path, int frames, const FrameFormat& format = some_format) {
  RecordingWriter writer(path, {.format = format});
  for (int i = 0; i < frames; ++i) writer.append(some_frame(i, format));
  writer.finish();
}

void expect_first_frames(const RecordingReader& reader) {
  Frame frame;
  for (std::uint64_t i = 0; i < reader.count(); ++i) {
    ASSERT_TRUE(reader.read(i, frame)) << i;
    const Frame expected = some_frame(static_cast<int>(i), reader.header().format);
    EXPECT_TRUE(same_pixels(frame, expected)) << i;
    EXPECT_EQ(frame.stamp.sequence, expected.stamp.sequence);
    EXPECT_EQ(frame.stamp.pattern_index, expected.stamp.pattern_index);
    EXPECT_EQ(frame.stamp.device_time, expected.stamp.device_time);
    EXPECT_EQ(frame.stamp.host_time, expected.stamp.host_time);
  }
}

TEST(Recording, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  for (const FrameFormat& format :
       {some_format, FrameFormat{{64, 2}, 12}, FrameFormat{{1, 1}, 8}}) {
    record(folder.path() / "frames", 7, format);
    const RecordingReader reader(folder.path() / "frames");
    EXPECT_EQ(reader.header().format, format);
    EXPECT_EQ(reader.count(), 7U);
    EXPECT_TRUE(reader.finished());
    EXPECT_EQ(reader.dropped(), 0U);
    expect_first_frames(reader);
  }
}

TEST(Recording, KeepsSequenceAndScanner) {
  const TemporaryFolder folder;
  Scanner scanner = example_scanner();
  scanner.photometry = {.ambient = 4.5, .noise_variance = 1.6};
  scanner.measured = "on a bench";
  const RecordingHeader header{.format = some_format,
                               .frame_rate = 119.5,
                               .sequence = Sequence{.strategy = PhaseMeasuring{.steps = 5},
                                                    .axis = Axis::y,
                                                    .light = {.alpha_p = 200, .beta_p = 20},
                                                    .projector = {1280, 800}},
                               .scanner = scanner};
  {
    RecordingWriter writer(folder.path() / "frames", header);
    writer.append(some_frame(0));
    writer.finish();
  }
  const RecordingReader reader(folder.path() / "frames");
  EXPECT_EQ(reader.count(), 1U);
  EXPECT_EQ(reader.header().frame_rate, 119.5);
  EXPECT_EQ(reader.header().sequence, header.sequence);
  EXPECT_EQ(reader.header().scanner, header.scanner);
}

RecordingHeader in_colour(const FrameFormat& format) {
  std::vector<Frame> white;
  for (int c = 0; c < 3; ++c) white.push_back(some_frame(100 + c, format));
  return {.format = format,
          .sequence = Sequence{.strategy = PhaseMeasuring{.steps = 3}},
          .in_colour = true,
          .white = frame_set_of(std::move(white))};
}

TEST(Recording, KeepsThatItIsInColourAndTheWhitePicture) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  for (const FrameFormat& format : {some_format, FrameFormat{{5, 3}, 12}}) {
    const RecordingHeader header = in_colour(format);
    RecordingWriter writer(path, header);
    for (int i = 0; i < 7; ++i) writer.append(some_frame(i, format));
    writer.finish();
    const RecordingReader reader(path);
    EXPECT_TRUE(reader.header().in_colour);
    EXPECT_EQ(reader.header().sequence, header.sequence);
    EXPECT_EQ(reader.count(), 7U);
    expect_first_frames(reader);
    const std::vector<Frame> white = frames_of(reader.header().white, "white");
    ASSERT_EQ(white.size(), 3U);
    for (int c = 0; c < 3; ++c) {
      EXPECT_TRUE(same_pixels(white[static_cast<std::size_t>(c)], some_frame(100 + c, format)));
    }
  }
  RecordingHeader without = in_colour(some_format);
  without.white = {};
  RecordingWriter writer(path, without);
  writer.append(some_frame(0));
  writer.finish();
  EXPECT_TRUE(RecordingReader(path).header().in_colour);
  EXPECT_EQ(RecordingReader(path).header().white.count(), 0);
}

/// Programs that support only grey recordings accept only version 1.
TEST(Recording, IsOfVersion2InColourAlone) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  record(path, 1);
  EXPECT_EQ(read_file(path)[8], 1);
  RecordingWriter writer(path, in_colour(some_format));
  writer.append(some_frame(0));
  writer.finish();
  std::vector<std::uint8_t> bytes = read_file(path);
  EXPECT_EQ(bytes[8], 2);
  const std::size_t header = bytes[12] | std::size_t{bytes[13]} << 8U;
  ASSERT_GT(header, 64U);
  ASSERT_LT(header, bytes.size());
  for (std::size_t at = 0; at < header; at += at < 64 ? 1 : 97) {
    std::vector<std::uint8_t> damaged = bytes;
    damaged[at] ^= 0x02;
    put_bytes(path, damaged);
    expect_error([&] { RecordingReader reader(path); }, {path.string()});
  }
  bytes[8] = 3;
  put_bytes(path, bytes);
  expect_error([&] { RecordingReader reader(path); }, {"version 3", "supported: 1 and 2"});
}

TEST(Recording, RefusesColoursThatAreNone) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  RecordingHeader four_steps = in_colour(some_format), marked = four_steps;
  four_steps.sequence->strategy = PhaseMeasuring{.steps = 4};
  expect_error([&] { RecordingWriter(path, four_steps); }, {"4 frames", "a multiple of 3"});
  marked.sequence->marker = true;
  expect_error([&] { RecordingWriter(path, marked); }, {"marker"});
  RecordingHeader grey = in_colour(some_format);
  grey.in_colour = false;
  expect_error([&] { RecordingWriter(path, grey); }, {"white picture"});
  RecordingHeader other = in_colour({{5, 3}, 12});
  other.format = some_format;
  expect_error([&] { RecordingWriter(path, other); }, {"5x3 with 12 bits", "21x13 with 8 bits"});
  EXPECT_FALSE(fs::exists(path));
}

TEST(Recording, InterruptedOpensUpToItsLastWholeFrame) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  record(path, 3);
  const std::vector<std::uint8_t> whole = read_file(path);
  constexpr std::size_t header = 64, record_size = 64 + 320;
  for (std::size_t length = header; length < whole.size(); ++length) {
    put_bytes(path, std::span(whole).first(length));
    const RecordingReader reader(path);
    const std::size_t rest = (length - header) % record_size;
    EXPECT_EQ(reader.count(), (length - header) / record_size) << length;
    EXPECT_EQ(reader.dropped(), rest > 0 ? 1U : 0U) << length;
    EXPECT_FALSE(reader.finished()) << length;
    if (rest == 0) expect_first_frames(reader);
  }
  for (std::size_t length = 0; length < header; ++length) {
    put_bytes(path, std::span(whole).first(length));
    expect_error([&] { RecordingReader reader(path); }, {path.string()});
  }
}

TEST(Recording, AbandonedOneIsRead) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  {
    RecordingWriter writer(path, {.format = some_format});
    for (int i = 0; i < 5; ++i) writer.append(some_frame(i));
  }
  const RecordingReader reader(path);
  EXPECT_EQ(reader.count(), 5U);
  EXPECT_FALSE(reader.finished());
  expect_first_frames(reader);
}

TEST(Recording, EachChangedByteOfAFrameIsFound) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  record(path, 2);
  const std::vector<std::uint8_t> whole = read_file(path);
  Frame frame;
  for (std::size_t at = 64; at < 64 + 64 + 320; ++at) {
    std::vector<std::uint8_t> damaged = whole;
    damaged[at] ^= 0x10;
    put_bytes(path, damaged);
    const RecordingReader reader(path);
    EXPECT_EQ(reader.count(), 2U);
    EXPECT_FALSE(reader.read(0, frame)) << at;
    EXPECT_TRUE(reader.read(1, frame)) << at;
  }
}

TEST(Recording, LastFramesThatNeverReachedTheDiskAreDropped) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  record(path, 4);
  std::vector<std::uint8_t> bytes = read_file(path);
  constexpr std::size_t two_frames = 64 + 2 * (64 + 320);
  std::fill(bytes.begin() + two_frames, bytes.end(), std::uint8_t{0});
  put_bytes(path, bytes);
  const RecordingReader reader(path);
  EXPECT_EQ(reader.count(), 2U);
  EXPECT_EQ(reader.dropped(), 3U);  // two frames and the end mark
  expect_first_frames(reader);
}

TEST(Recording, PowerLossKeepsAllFramesThatWereSynced) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  constexpr std::size_t header = 64, record_size = 64 + 320, frames = 12;
  record(path, frames);
  const std::vector<std::uint8_t> whole = read_file(path);
  std::mt19937 random(1);
  for (int tries = 0; tries < 2000; ++tries) {
    // Simulates a crash: bytes after the last sync are partly zero, and the file is cut anywhere.
    const std::size_t synced = random() % (frames + 1);
    std::vector<std::uint8_t> bytes = whole;
    for (std::size_t at = header + synced * record_size; at < bytes.size();) {
      const std::size_t end = std::min(at + 1 + random() % 600, bytes.size());
      if (random() % 2 == 0)
        std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                  bytes.begin() + static_cast<std::ptrdiff_t>(end), 0);
      at = end;
    }
    const std::size_t least = header + synced * record_size;
    bytes.resize(least + random() % (bytes.size() - least + 1));
    put_bytes(path, bytes);
    const RecordingReader reader(path);
    ASSERT_GE(reader.count(), synced);
    Frame frame;
    for (std::uint64_t i = 0; i < reader.count(); ++i) {
      const bool read = reader.read(i, frame);
      if (i < synced) ASSERT_TRUE(read);
      if (read) ASSERT_TRUE(same_pixels(frame, some_frame(static_cast<int>(i))));
    }
  }
}

TEST(Recording, LengthWithoutFramesIsNotSearchedForEver) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  record(path, 5);
  const auto before = fs::file_size(path) - 16;
  for (const std::uintmax_t length : {std::uintmax_t{1} << 33, std::uintmax_t{1} << 42}) {
    fs::resize_file(path, before);
    fs::resize_file(path, length);
    const RecordingReader reader(path);
    EXPECT_EQ(reader.count(), 5U);
    EXPECT_FALSE(reader.finished());
    expect_first_frames(reader);
  }
}

TEST(Recording, OldOneStaysUntilTheNewOneIsWhole) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  record(path, 3);
  RecordingWriter writer(path, {.format = some_format});
  for (int i = 0; i < 5; ++i) writer.append(some_frame(i));
  EXPECT_EQ(RecordingReader(path).count(), 3U);
  writer.finish();
  EXPECT_EQ(RecordingReader(path).count(), 5U);
  EXPECT_EQ(entries_in(folder.path()), 1);
  {
    const SmallDisk disk(100);
    RecordingWriter none(path, {.format = some_format});
    EXPECT_THROW(none.append(some_frame(0)), WorldError);
  }
  EXPECT_EQ(RecordingReader(path).count(), 5U);
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(Recording, WithoutAFrameTheOldOneStays) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  RecordingWriter(path, {.format = some_format}).finish();
  EXPECT_EQ(entries_in(folder.path()), 0);
  record(path, 3);
  RecordingWriter(path, {.format = some_format}).finish();
  { const RecordingWriter abandoned(path, {.format = some_format}); }
  EXPECT_EQ(RecordingReader(path).count(), 3U);
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(Recording, TimesThatCannotBeAddedAreDamage) {
  const TemporaryFolder folder;
  constexpr std::chrono::nanoseconds too_long(std::int64_t{1} << 61);
  {
    RecordingWriter writer(folder.path() / "frames", {.format = some_format});
    for (const auto& time : {too_long, -too_long, too_long - std::chrono::nanoseconds(1)}) {
      Frame frame = some_frame(0);
      frame.stamp.device_time = time;
      writer.append(frame);
    }
    writer.finish();
  }
  const RecordingReader reader(folder.path() / "frames");
  Frame frame;
  EXPECT_FALSE(reader.read(0, frame));
  EXPECT_FALSE(reader.read(1, frame));
  EXPECT_TRUE(reader.read(2, frame));
}

TEST(Recording, ChangedHeaderIsRefused) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  record(path, 1);
  const std::vector<std::uint8_t> whole = read_file(path);
  for (std::size_t at = 0; at < 64; ++at) {
    std::vector<std::uint8_t> damaged = whole;
    damaged[at] ^= 0x01;
    put_bytes(path, damaged);
    expect_error([&] { RecordingReader reader(path); }, {path.string()});
  }
}

TEST(Recording, RefusesWhatIsNoRecording) {
  const TemporaryFolder folder;
  expect_error([&] { RecordingReader reader(folder.path() / "none"); }, {"none", "no such file"});
  expect_error([&] { RecordingReader reader(folder.path()); }, {"expected a file"});
  write_file(folder.path() / "text", std::string(100, 'x'));
  expect_error([&] { RecordingReader reader(folder.path() / "text"); },
               {"is not a slipstream recording"});
}

TEST(Recording, RefusesAFrameOfAnotherFormat) {
  const TemporaryFolder folder;
  RecordingWriter writer(folder.path() / "frames", {.format = some_format});
  expect_error([&] { writer.append(some_frame(0, {{22, 13}, 8})); }, {"22x13", "21x13"});
  expect_error([&] { writer.append(some_frame(0, {{21, 13}, 10})); }, {"10 bits"});
}

TEST(Recording, BadHeaderLeavesNoFile) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  expect_error([&] { RecordingWriter(path, {.format = {{0, 3}, 8}}); }, {"0x3"});
  expect_error([&] { RecordingWriter(path, {.format = some_format, .frame_rate = -1}); }, {"-1"});
  EXPECT_FALSE(fs::exists(path));
  EXPECT_THROW(RecordingWriter(folder.path() / "no" / "frames", {.format = some_format}),
               WorldError);
}

TEST(Recording, FullDiskEndsItWithTheFrameBefore) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "frames";
  {
    RecordingWriter writer(path, {.format = some_format});
    const SmallDisk disk(2000);
    int written = 0;
    try {
      for (; written < 100; ++written) writer.append(some_frame(written));
      ADD_FAILURE() << "the disk was not full";
    } catch (const WorldError& error) {
      EXPECT_NE(std::string(error.what()).find("the 5 frames before are recorded"),
                std::string::npos)
          << error.what();
    }
    EXPECT_EQ(written, 5);
    EXPECT_EQ(writer.count(), 5U);
  }
  const RecordingReader reader(path);
  EXPECT_EQ(reader.count(), 5U);
  EXPECT_EQ(reader.dropped(), 0U);
  expect_first_frames(reader);
}

TEST(Recording, NoRoomForTheHeaderLeavesNoFile) {
  const TemporaryFolder folder;
  const SmallDisk disk(10);
  EXPECT_THROW(RecordingWriter(folder.path() / "frames", {.format = some_format}), WorldError);
  EXPECT_EQ(entries_in(folder.path()), 0);
}

}  // namespace slipstream::recording_test
