#include "io/pattern_pictures.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/phase_shifting.h"
#include "tests/io/grey_image.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::pattern_pictures_test {
namespace fs = std::filesystem;

const Sequence shown{.strategy = PhaseMeasuring{4}, .projector = {6, 4}};

TEST(PatternPictures, AreNamedInOrderInAFolderThatIsMade) {
  const TemporaryFolder temporary;
  const fs::path folder = temporary.path() / "patterns";
  const PatternSet patterns = pattern_set(shown);
  int written = 0;
  const auto paths = write_patterns(folder, patterns, shown, 8, [&] { ++written; });
  EXPECT_EQ(written, 4);
  ASSERT_EQ(paths.size(), 4U);
  for (int n = 0; n < 4; ++n) {
    const fs::path file = pattern_file(folder, static_cast<std::size_t>(n));
    EXPECT_EQ(paths[static_cast<std::size_t>(n)], file);
    const Image<std::uint16_t> picture = read_grey_image(file);
    EXPECT_EQ(picture.size(), (Size{6, 4}));
    EXPECT_EQ(picture(5, 3), render_pattern(patterns, n, {6, 4}, 8)(5, 3));
  }
}

TEST(PatternPictures, AFolderThatCannotBeMadeIsOfTheWorld) {
  EXPECT_THROW(write_patterns("/proc/patterns", pattern_set(shown), shown, 8, [] {}), WorldError);
}

}  // namespace slipstream::pattern_pictures_test
