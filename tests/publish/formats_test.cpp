// Reads back the files that sinks write, with readers written here from the format specifications.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <zstd.h>

#include "io/file.h"
#include "publish/mcap.h"
#include "publish/mcap_reader.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"
#include "slipstream/ros_messages.h"
#include "slipstream/strategy.h"
#include "tests/io/expect_error.h"
#include "tests/io/small_disk.h"
#include "tests/io/temporary_folder.h"
#include "tests/publish/any_cloud.h"
#include "tests/publish/little_endian_reader.h"

namespace slipstream::formats_test {
using namespace std::string_view_literals;

using Bytes = std::vector<std::uint8_t>;

struct McapFile {
  std::map<std::uint16_t, std::string> topics, schemas;  ///< by channel ID and schema ID
  std::map<std::string, std::vector<Bytes>> messages;    ///< by topic
  std::map<std::string, std::vector<std::uint32_t>> numbers;
  std::map<std::string, std::string> attachments;
  int chunks = 0, indices = 0;
  bool has_end = false;
};

void read_records(LittleEndianReader reader, McapFile& file) {
  while (reader.at + 9 <= reader.bytes.size()) {
    const auto opcode = reader.get<std::uint8_t>();
    const auto length = reader.get<std::uint64_t>();
    if (reader.at + length > reader.bytes.size()) return;  // incomplete last record
    LittleEndianReader record{reader.take(length)};
    if (opcode == 3) {
      const auto number = record.get<std::uint16_t>();
      file.schemas[number] = record.text();
      EXPECT_EQ(record.text(), "ros2msg");
    } else if (opcode == 4) {
      const auto number = record.get<std::uint16_t>();
      EXPECT_EQ(record.get<std::uint16_t>(), number);
      file.topics[number] = record.text();
      EXPECT_EQ(record.text(), "cdr");
    } else if (opcode == 5) {
      const auto channel = record.get<std::uint16_t>();
      file.numbers[file.topics.at(channel)].push_back(record.get<std::uint32_t>());
      record.take(8 + 8);
      const auto content = record.take(length - record.at);
      file.messages[file.topics.at(channel)].emplace_back(content.begin(), content.end());
    } else if (opcode == 6) {
      ++file.chunks;
      record.take(16);
      Bytes unpacked(record.get<std::uint64_t>());
      const auto sum = record.get<std::uint32_t>();
      EXPECT_EQ(record.text(), "zstd");
      const auto packed = record.take(record.get<std::uint64_t>());
      EXPECT_EQ(record.at, length);
      ASSERT_EQ(ZSTD_decompress(unpacked.data(), unpacked.size(), packed.data(), packed.size()),
                unpacked.size());
      EXPECT_EQ(checksum(unpacked), sum);
      read_records({unpacked}, file);
    } else if (opcode == 9) {
      record.take(8 + 8);
      const std::string name = record.text();
      EXPECT_EQ(record.text(), "application/yaml");
      const auto text = record.take(record.get<std::uint64_t>());
      file.attachments[name].append(text.begin(), text.end());
      const auto before_sum = record.bytes.first(record.at);
      EXPECT_EQ(record.get<std::uint32_t>(), checksum(before_sum));
    } else if (opcode == 8) {
      ++file.indices;
    } else if (opcode == 2) {
      file.has_end = true;
      EXPECT_EQ(reader.bytes.size() - reader.at, 8U);
      const auto summary = record.get<std::uint64_t>();
      record.take(8);
      const auto before_sum = reader.bytes.subspan(summary - 8, reader.at - 4 - (summary - 8));
      EXPECT_EQ(record.get<std::uint32_t>(), checksum(before_sum));
      return;
    }
  }
}

McapFile read_mcap(const std::filesystem::path& path) {
  const Bytes bytes = read_file(path);
  McapFile file;
  EXPECT_EQ(std::memcmp(bytes.data(), "\x89MCAP0\r\n", 8), 0);
  read_records({std::span(bytes).subspan(8)}, file);
  return file;
}

void expect_points(const Bytes& message, const Cloud& cloud) {
  LittleEndianReader cdr{message};
  EXPECT_EQ(cdr.get<std::uint32_t>(), 0x100U);  // little-endian CDR
  EXPECT_GT(cdr.aligned<std::int32_t>(), 1'700'000'000);
  EXPECT_LT(cdr.aligned<std::uint32_t>(), 1'000'000'000U);
  EXPECT_EQ(cdr.aligned_text(), "camera");
  EXPECT_EQ(cdr.aligned<std::uint32_t>(), 43U);
  EXPECT_EQ(cdr.aligned<std::uint32_t>(), 61U);
  ASSERT_EQ(cdr.aligned<std::uint32_t>(), 4U);
  for (const char* name : {"x", "y", "z", "intensity"}) {
    EXPECT_EQ(cdr.aligned_text(), name);
    cdr.aligned<std::uint32_t>();
    EXPECT_EQ(cdr.get<std::uint8_t>(), 7);
    EXPECT_EQ(cdr.aligned<std::uint32_t>(), 1U);
  }
  EXPECT_EQ(cdr.get<std::uint8_t>(), 0);
  EXPECT_EQ(cdr.aligned<std::uint32_t>(), 16U);
  EXPECT_EQ(cdr.aligned<std::uint32_t>(), 16U * 61);
  ASSERT_EQ(cdr.aligned<std::uint32_t>(), 16U * 61 * 43);
  int different = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    for (const Image<float>* const axis : {&cloud.x, &cloud.y, &cloud.z}) {
      const float metres = axis->begin()[i] / 1000;
      const auto told = cdr.get<std::uint32_t>();
      if (told != std::bit_cast<std::uint32_t>(metres)) ++different;
    }
    if (cdr.get<float>() != cloud.intensity.begin()[i]) ++different;
  }
  EXPECT_EQ(different, 0);
  EXPECT_EQ(cdr.get<std::uint8_t>(), 0);
  EXPECT_EQ(cdr.at, message.size());
}

TEST(Formats, McapHoldsEveryPointBitForBitAndCanBeReadBeforeItsEndIsWritten) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "clouds.mcap";
  const auto sink = open_sink("mcap:" + path.string(), {.camera = camera()});
  constexpr int count = 150;  // 46 KB each: several chunks
  for (std::uint64_t i = 0; i < count; ++i) sink->put(any_cloud(i), false);
  const McapFile interrupted = read_mcap(path);
  EXPECT_FALSE(interrupted.has_end);
  EXPECT_GE(interrupted.chunks, 1);
  EXPECT_GE(interrupted.messages.at("/points").size(), 80U);
  sink->finish();

  const McapFile file = read_mcap(path);
  EXPECT_TRUE(file.has_end);
  EXPECT_EQ(file.indices, file.chunks);
  ASSERT_EQ(file.messages.at("/points").size(), std::size_t{count});
  EXPECT_EQ(file.messages.at("/image").size(), std::size_t{count});
  for (std::uint64_t i = 0; i < count; i += 49) {
    expect_points(file.messages.at("/points")[i], any_cloud(i)->cloud);
  }
  const Bytes& image = file.messages.at("/image").front();
  EXPECT_EQ(image.back(), grey_level(any_cloud(0)->cloud.intensity(60, 42)));
}

TEST(Formats, McapEndsWithTheChunkBeforeWhereTheDiskIsFull) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "clouds.mcap";
  const auto sink = open_sink("mcap:" + path.string(), {.camera = camera()});
  std::uint64_t clouds = 0;
  while (clouds < 100) sink->put(any_cloud(clouds++), false);
  const auto bytes = std::filesystem::file_size(path);
  const auto fill = [&] {
    const SmallDisk disk(bytes);
    while (clouds < 1000) sink->put(any_cloud(clouds++), false);
  };
  EXPECT_THROW(fill(), WorldError);
  sink->finish();  // after a failure: no effect
  EXPECT_EQ(std::filesystem::file_size(path), bytes);
  const McapFile left = read_mcap(path);
  EXPECT_FALSE(left.has_end);
  EXPECT_EQ(left.chunks, 1);
}

TEST(Formats, McapWithoutACloudLeavesTheOldOne) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "clouds.mcap";
  write_file(path, "old");
  open_sink("mcap:" + path.string(), {.camera = camera()})->finish();
  (void)open_sink("mcap:" + path.string(), {.camera = camera()});
  EXPECT_EQ(read_text(path), "old");
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(Formats, McapHoldsFramesStatisticsAndWhatTheScanWasMadeWith) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "clouds.mcap";
  Pooled<LiveCloud> cloud = any_cloud(9);
  Pool<Frame> frames(4, [] { return Frame(FrameFormat{size}); });
  for (std::uint64_t pattern = 0; pattern < 4; ++pattern) {  // the window is 6, 7, 8, 9
    Pooled<Frame> frame = frames.take();
    frame.fill().stamp = {.sequence = pattern < 2 ? 8 + pattern : 4 + pattern,
                          .host_time = cloud->newest.host_time};
    std::get<Image<std::uint8_t>>(frame.fill().pixels)(60, 42) = static_cast<std::uint8_t>(pattern);
    cloud.fill().frames[pattern] = frame;
  }
  Uncertainty sigma(size);
  sigma.z(60, 42) = 50;
  const auto sink =
      open_sink("mcap:" + path.string(),
                {.camera = camera(),
                 .scanner = "a scanner",
                 .statistics = [] { return std::string("{}"); },
                 .uncertainty = [&](const LiveCloud&) { return std::optional(sigma); }});
  const auto put = [&](const Sequence& sequence, bool alone) {
    cloud.fill().sequence = std::make_shared<const Sequence>(sequence);
    sink->put(cloud, alone);
  };
  put({.strategy = make_strategy("pmp", {{"steps", 4}})}, false);
  put({.strategy = make_strategy("pmp", {{"steps", 5}})}, true);
  put({.strategy = make_strategy("pmp", {{"steps", 3}}), .motion = 1}, false);
  cloud.fill().sequence = nullptr;
  sink->put(cloud, false);
  sink->finish();

  const McapFile file = read_mcap(path);
  EXPECT_EQ(file.attachments.at("scanner.yaml"), "a scanner");
  const std::string& scans = file.attachments.at("scan.yaml");
  EXPECT_NE(scans.find("steps: 4"), std::string::npos);
  EXPECT_EQ(scans.find("steps: 5"), std::string::npos);
  EXPECT_NE(scans.find("steps: 3"), std::string::npos);
  for (std::uint8_t pattern = 0; pattern < 4; ++pattern) {
    const std::string topic = "/frames/" + std::to_string(pattern);
    EXPECT_EQ(file.messages.at(topic).size(), pattern == 3 ? 1U : pattern == 0 ? 3U : 2U);
    EXPECT_EQ(file.messages.at(topic).front().back(), pattern);
    EXPECT_EQ(file.numbers.at(topic).front(), pattern < 2 ? 8U + pattern : 4U + pattern);
  }
  EXPECT_EQ(file.messages.at("/camera_info").size(), 4U) << "two of them without frames";
  EXPECT_EQ(file.messages.at("/statistics").size(), 1U) << "once a second";
  const StoredCloud stored = read_point_cloud(file.messages.at("/points").front());
  ASSERT_TRUE(stored.uncertainty);
  EXPECT_EQ(stored.uncertainty->z(60, 42), 50);
}

TEST(Formats, McapStopsAtItsLimitOrKeepsTheNewest) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.mcap", before = folder.path() / "a-before.mcap";
  constexpr std::uint64_t most = 1'000'000, cloud = 50'000;  // bytes
  const auto clouds_in = [&](const std::filesystem::path& file) {
    EXPECT_TRUE(read_mcap(file).has_end);
    return read_mcap(file).numbers.at("/points").size();
  };
  for (const bool ring : {false, true}) {
    const auto sink = open_sink("mcap:" + path.string(),
                                {.camera = camera(), .limit = {.bytes = most, .ring = ring}});
    EXPECT_TRUE(sink->news().empty());
    for (std::uint64_t i = 0; i < 60; ++i) sink->put(any_cloud(i), false);
    sink->finish();
    const auto news = sink->news();
    ASSERT_EQ(news.size(), 1U);
    EXPECT_NE(news.front().find("limit reached"), std::string::npos);
    EXPECT_TRUE(sink->news().empty());
    EXPECT_GE(clouds_in(path), 5U);
    EXPECT_LE(std::filesystem::file_size(path), most + cloud);
    EXPECT_EQ(std::filesystem::exists(before), ring);
  }
  EXPECT_GE(clouds_in(before), 5U);
  EXPECT_LE(clouds_in(path) + clouds_in(before), 40U);
}

TEST(Formats, McapIsGivenCloudsThatShareNoFrame) {
  const TemporaryFolder folder;
  const auto sink = open_sink("mcap:" + (folder.path() / "a.mcap").string(), {.camera = camera()});
  std::vector<std::uint64_t> wanted;
  for (const std::uint64_t i : {3, 4, 5, 6, 7, 8, 13, 14, 16, 17, 2, 3}) {
    if (sink->wants(*any_cloud(i))) wanted.push_back(i);
  }
  EXPECT_EQ(wanted, (std::vector<std::uint64_t>{3, 7, 13, 17, 2}));
}

/// An MCAP file of that many zstd chunks, which hold zeros of no message each.
std::vector<std::uint8_t> packed_zeros(int chunks) {
  constexpr std::size_t size = std::size_t{64} << 20, record_head = 1 + 8;
  constexpr std::uint8_t metadata = 0x0c;
  std::vector<std::uint8_t> zeros{metadata}, packed(ZSTD_compressBound(size));
  mcap::append(zeros, std::uint64_t{size - record_head});
  zeros.resize(size);
  packed.resize(ZSTD_compress(packed.data(), packed.size(), zeros.data(), zeros.size(), 1));

  std::vector<std::uint8_t> content, file(mcap::magic.begin(), mcap::magic.end());
  mcap::append(content, std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{size}, std::uint32_t{0},
               "zstd"sv, std::uint64_t{packed.size()}, packed);

  for (int n = 0; n < chunks; ++n) {
    mcap::append(file, std::uint8_t{mcap::chunk}, std::uint64_t{content.size()}, content);
  }
  return file;
}

TEST(Formats, McapUnpacksNoMoreThanItsSizeAllows) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "zeros.mcap";
  const auto read = [&] { (void)slipstream::read_mcap(path, [](const McapMessage&) {}); };

  write_file(path, packed_zeros(2));
  EXPECT_NO_THROW(read());

  // More than 1 GiB, of 100 kB.
  write_file(path, packed_zeros(18));
  ASSERT_LT(std::filesystem::file_size(path), 200'000U);
  expect_error(read, {"zeros.mcap", "200 times its size"});
}

TEST(Formats, McapNamesOfChannelsAreShort) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "long.mcap";
  std::vector<std::uint8_t> content, file(mcap::magic.begin(), mcap::magic.end());
  mcap::append(content, std::uint16_t{1}, std::uint16_t{1}, std::string(5000, 'a'), "cdr"sv);
  mcap::append(file, std::uint8_t{mcap::channel}, std::uint64_t{content.size()}, content);
  write_file(path, file);
  expect_error([&] { (void)slipstream::read_mcap(path, [](const McapMessage&) {}); },
               {"long.mcap", "5000 letters; limit 4096"});
}

// rviz and PCL read the bytes of a float named rgb: blue, green, red and nothing.
TEST(Formats, RosMessagesHaveColoursPackedInAFloat) {
  const Pooled<LiveCloud> live = coloured_cloud();
  for (const bool has_sigma : {false, true}) {
    const Uncertainty sigma(size);
    RosMessage message;
    write_point_cloud(live->cloud, {1}, message, has_sigma ? &sigma : nullptr);

    LittleEndianReader cdr{message};
    cdr.take(12);
    cdr.aligned_text();
    cdr.aligned<std::uint32_t>();
    cdr.aligned<std::uint32_t>();
    const auto fields = cdr.aligned<std::uint32_t>();
    ASSERT_EQ(fields, has_sigma ? 9U : 5U);
    std::uint32_t offset = 0;
    std::string name;
    for (std::uint32_t i = 0; i < fields; ++i) {
      name = cdr.aligned_text();
      offset = cdr.aligned<std::uint32_t>();
      EXPECT_EQ(cdr.get<std::uint8_t>(), 7) << "FLOAT32";
      EXPECT_EQ(cdr.aligned<std::uint32_t>(), 1U);
    }
    EXPECT_EQ(name, "rgb");
    EXPECT_EQ(offset, 4 * (fields - 1));

    cdr.get<std::uint8_t>();
    const auto step = cdr.aligned<std::uint32_t>();
    EXPECT_EQ(step, 4 * fields);
    cdr.aligned<std::uint32_t>();
    const auto data = cdr.take(cdr.aligned<std::uint32_t>());
    for (std::size_t i = 0; i < live->cloud.z.pixel_count(); ++i) {
      const auto [red, green, blue] = live->cloud.colour.begin()[i];
      const std::uint8_t* const at = data.data() + i * step + offset;
      ASSERT_TRUE(at[0] == blue && at[1] == green && at[2] == red && at[3] == 0) << i;
    }

    const Cloud read = read_point_cloud(message).cloud;
    EXPECT_TRUE(std::ranges::equal(read.colour, live->cloud.colour));
  }
}

TEST(Formats, RosMessagesHaveAPictureInColour) {
  const Pooled<LiveCloud> live = coloured_cloud();
  RosMessage message;
  write_image(live->cloud, {1}, message);
  LittleEndianReader cdr{message};
  cdr.take(12);
  cdr.aligned_text();
  cdr.aligned<std::uint32_t>();
  cdr.aligned<std::uint32_t>();
  EXPECT_EQ(cdr.aligned_text(), "rgb8");
  cdr.get<std::uint8_t>();
  EXPECT_EQ(cdr.aligned<std::uint32_t>(), 3U * 61) << "bytes of a row";
  const auto data = cdr.take(cdr.aligned<std::uint32_t>());
  EXPECT_EQ(std::memcmp(data.data(), live->cloud.colour.begin(), data.size()), 0);
}

}  // namespace slipstream::formats_test
