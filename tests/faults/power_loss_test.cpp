// What a recording holds after a loss of power: the program's own writes and syncs, in their order,
// and the disk as it may be after each of them.
#include <algorithm>
#include <map>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "slipstream/recording.h"
#include "tests/faults/faulted_program.h"
#include "tests/recording/recorded_frames.h"

#ifdef SLIPSTREAM_FAULT_LIBRARY
namespace slipstream::power_loss_test {
namespace fs = std::filesystem;

/// More bytes than a recording leaves unsynced.
constexpr FrameFormat large{{2048, 1024}, 8};
constexpr std::uint64_t frames = 40, record_bytes = 64 + 2048 * 1024;

std::vector<FileEvent> events_of(const FaultRecord& record) {
  EXPECT_LE(record.events_made, most_events);
  return {record.events, record.events + record.events_made};
}

/// That most was written to.
int recording_among(const std::vector<FileEvent>& events) {
  std::map<int, std::uint64_t> bytes;
  for (const auto& [call, descriptor, written] : events) bytes[descriptor] += written;
  const auto by_bytes = [](const auto& a, const auto& b) { return a.second < b.second; };
  return std::max_element(bytes.begin(), bytes.end(), by_bytes)->first;
}

/// Bytes of the file when the power goes.
struct Cut {
  std::uint64_t synced = 0, written = 0;
};

/// Right before and after each sync of the recording; expects that there is one in time.
std::vector<Cut> cuts_in(const std::vector<FileEvent>& events) {
  const int recording = recording_among(events);
  std::vector<Cut> cuts;
  Cut now;
  bool is_renamed = false, is_name_synced = false;
  for (const auto& [call, descriptor, bytes] : events) {
    if (call == of_fsync && is_renamed) is_name_synced = true;  // its folder, by any number
    if (call == of_rename) {
      EXPECT_EQ(now.synced, now.written) << "it has its name before it is on the disk";
      is_renamed = true;
    }
    if (descriptor != recording || is_renamed) continue;
    if (call == of_write) now.written += bytes;
    EXPECT_LE(now.written - now.synced, OutputFile::most_unsynced + record_bytes);
    if (call != of_fsync) continue;
    cuts.push_back(now);
    now.synced = now.written;
    cuts.push_back(now);
  }
  EXPECT_TRUE(is_name_synced);
  return cuts;
}

/// Where `unsynced` is what was not: all of it lost, zeros, or some blocks of it and any length.
void lose(std::vector<std::uint8_t>& bytes, std::uint64_t synced, int how, std::mt19937& random) {
  const auto unsynced = std::span(bytes).subspan(synced);
  if (how == 0) return bytes.resize(synced);
  constexpr std::size_t block = 4096;
  for (std::size_t at = 0; at < unsynced.size(); at += block) {
    if (how == 1 || random() % 2 == 0) {
      std::ranges::fill(unsynced.subspan(at, std::min(block, unsynced.size() - at)), 0);
    }
  }
  if (how == 2) bytes.resize(synced + random() % (unsynced.size() + 1));
}

/// All frames that are whole up to `synced` are there, and none is another's.
void expect_kept(const RecordingReader& left, const RecordingReader& whole, std::uint64_t synced,
                 std::uint64_t header_bytes) {
  const std::uint64_t promised = std::min(frames, (synced - header_bytes) / record_bytes);
  ASSERT_GE(left.count(), promised);
  Frame frame, expected;
  for (std::uint64_t i = 0; i < left.count(); ++i) {
    const bool is_read = left.read(i, frame);
    if (i < promised) ASSERT_TRUE(is_read) << i;
    ASSERT_TRUE(whole.read(i, expected));
    if (is_read) ASSERT_TRUE(same_pixels(frame, expected)) << i;
  }
}

/// A recording to be recorded anew, over an old one, which is there until the new one is whole.
class PowerLoss : public testing::Test {
 protected:
  void SetUp() override {
    RecordingWriter writer(played_, {.format = large});
    for (std::uint64_t i = 0; i < frames; ++i) {
      writer.append(some_frame(static_cast<int>(i), large));
    }
    writer.finish();
    write_file(made_, "old");
  }

  TemporaryFolder folder_;
  const fs::path played_ = folder_.path() / "played.slip", made_ = folder_.path() / "made.slip";
  FaultedProgram program_{{"record", "--source", "replay:" + played_.string(), "--rate", "0",
                           "--strategy", "pmp", "--steps", "4", "-o", made_.string()},
                          false};
};

TEST_F(PowerLoss, CostsARecordingNoFrameThatWasSynced) {
  ASSERT_EQ(program_.run({}), 0) << program_.err();
  const std::vector<Cut> cuts = cuts_in(events_of(program_.record()));
  ASSERT_GE(cuts.size(), 4U);  // one on the way, one at the end
  const std::vector<std::uint8_t> whole = read_file(made_);
  ASSERT_EQ(cuts.back().written, whole.size());
  const std::uint64_t header_bytes = whole.size() - 16 - frames * record_bytes;
  const TemporaryFolder memory(fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path());
  std::mt19937 random(1);
  for (const auto& [synced, written] : cuts) {
    if (synced < header_bytes) continue;  // nothing is promised yet
    for (int how = 0; how < 3; ++how) {
      std::vector<std::uint8_t> bytes(whole.begin(),
                                      whole.begin() + static_cast<std::ptrdiff_t>(written));
      lose(bytes, synced, how, random);
      const fs::path left = memory.path() / "left.slip";
      put_bytes(left, bytes);
      expect_kept(RecordingReader(left), RecordingReader(played_), synced, header_bytes);
    }
  }
}

TEST_F(PowerLoss, OfADiskThatFailsNoFrameIsClaimed) {
  ASSERT_EQ(program_.run({of_fsync, 1}), 1);
  EXPECT_NE(program_.err().find("of the 31 frames before, 0 are safely on disk"), std::string::npos)
      << program_.err();
  EXPECT_EQ(contents(made_), "old");
  EXPECT_NE(program_.err().find(".part"), std::string::npos) << program_.err();
}

}  // namespace slipstream::power_loss_test
#endif
