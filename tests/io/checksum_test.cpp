#include <gtest/gtest.h>

#include "io/file.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/recording.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"
#include "tests/recording/recorded_frames.h"

namespace slipstream::checksum_test {
namespace fs = std::filesystem;

TEST(Checksum, IsThatOfZlib) {
  const TemporaryFolder folder;
  write_file(folder.path() / "text", "123456789");
  EXPECT_EQ(checksum_of_file(folder.path() / "text"), 0xcbf43926U);
  write_file(folder.path() / "large", std::string(3 << 20, 'a'));
  const std::vector<std::uint8_t> large(3 << 20, 'a');
  EXPECT_EQ(checksum_of_file(folder.path() / "large"), checksum(large));
  expect_error([&] { (void)checksum_of_file(folder.path() / "none"); }, {"none", "no such file"});
}

/// 12 frames of four patterns; frame `other` is replaced with a different one.
RecordingReader recording(const fs::path& path, int other) {
  const Sequence shown{.strategy = PhaseMeasuring{.steps = 4}};
  RecordingWriter writer(path, {.format = some_format, .sequence = shown});
  for (int n = 0; n < 12; ++n) {
    Frame frame = some_frame(n);
    if (n == other) frame.pixels = some_frame(99).pixels;
    writer.append(frame);
  }
  writer.finish();
  return RecordingReader(path);
}

TEST(Checksum, OfAWindowIsThatOfItsFrames) {
  const TemporaryFolder folder;
  const RecordingReader one = recording(folder.path() / "one.slip", -1);
  const RecordingReader other = recording(folder.path() / "other.slip", 2);
  const Sequence& shown = *one.header().sequence;
  const auto of = [&](const RecordingReader& reader, std::uint64_t window) {
    return cycle_checksum(reader, shown, window, 0);
  };
  EXPECT_NE(of(one, 0), of(other, 0));
  EXPECT_EQ(of(one, 1), of(other, 1)) << "the other windows are as they were";
  EXPECT_EQ(of(one, 2), of(other, 2));
  EXPECT_NE(of(one, 1), of(one, 2));
  EXPECT_EQ(one.checksum(0, 0, 0), other.checksum(0, 0, 0)) << "of the header alone";
  EXPECT_NE(cycle_checksum(one, shown, std::nullopt, 0),
            cycle_checksum(other, shown, std::nullopt, 0));
}

}  // namespace slipstream::checksum_test
