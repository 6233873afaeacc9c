#include "slipstream/io/pattern_pictures.h"

#include <filesystem>
#include <stdexcept>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/io/image_file.h"
#include "tests/io/expect_error.h"
#include "tests/io/grey_image.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::folder_sink_test {
namespace fs = std::filesystem;

using Picture = Image<std::uint8_t>;

TEST(FolderSink, WritesEachPatternWhenItIsShown) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary.path() / "patterns";
  FolderSink sink(folder);
  EXPECT_FALSE(sink.size());
  sink.load({Picture({6, 4}, 10), Picture({6, 4}, 20)});
  EXPECT_FALSE(fs::exists(folder));
  sink.show(1);
  EXPECT_FALSE(fs::exists(folder / "pattern_00.png"));
  const Image<std::uint16_t> written = read_grey_image(folder / "pattern_01.png");
  EXPECT_EQ(written.size(), (Size{6, 4}));
  EXPECT_EQ(written(5, 3), 20);
  sink.show(0);
  EXPECT_EQ(read_grey_image(pattern_file(folder, 0))(0, 0), 10);
  EXPECT_EQ(sink.shown(), 2U);
}

TEST(FolderSink, RefusesWhatIsNoSetOfPatterns) {
  const TemporaryFolder temporary;
  FolderSink sink(temporary.path());
  expect_error([&] { sink.load({}); }, {"no pattern"});
  expect_error([&] { sink.load({Picture({6, 4}), Picture({4, 6})}); }, {"4x6", "the first is 6x4"});
  EXPECT_THROW(sink.show(0), std::out_of_range);
}

TEST(FolderSink, AFolderThatCannotBeMadeIsOfTheWorld) {
  FolderSink sink("/proc/patterns");
  sink.load({Picture({6, 4})});
  EXPECT_THROW(sink.show(0), WorldError);
  EXPECT_EQ(sink.shown(), 0U);
}

}  // namespace slipstream::folder_sink_test
