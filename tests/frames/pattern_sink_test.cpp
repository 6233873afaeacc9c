#include "slipstream/frames/pattern_sink.h"

#include <gtest/gtest.h>

#include "tests/io/expect_error.h"

namespace slipstream::pattern_sink_test {

using Picture = Image<std::uint8_t>;

TEST(RequirePatterns, TakesPatternsOfOneSizeAndOfTheDevices) {
  EXPECT_NO_THROW(require_patterns({Picture({6, 4}), Picture({6, 4})}, std::nullopt, "a folder"));
  EXPECT_NO_THROW(require_patterns({Picture({6, 4})}, Size{6, 4}, "monitor 1"));
}

TEST(RequirePatterns, SaysWhatDoesNotFit) {
  expect_error([] { require_patterns({}, Size{6, 4}, "monitor 1"); }, {"no pattern"});
  expect_error(
      [] {
        require_patterns({Picture({4, 6})}, Size{6, 4}, "monitor 1");
      },
      {"the patterns are 4x6, but monitor 1 is 6x4"});
  expect_error(
      [] {
        require_patterns({Picture({6, 4}), Picture({4, 6})}, std::nullopt, "a folder");
      },
      {"the patterns are 4x6, but the first is 6x4"});
}

}  // namespace slipstream::pattern_sink_test
