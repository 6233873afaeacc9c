#include "slipstream/live/finding_log.h"

#include <string>

#include <gtest/gtest.h>

namespace slipstream::finding_log_test {

Finding finding(const std::string& what, double value = 0) {
  return {.what = what, .evidence = {{"value", value}}};
}

TEST(FindingLog, KnowsWhenWhatBeganAndEnded) {
  FindingLog log;
  log.replace({}, 3);
  EXPECT_TRUE(log.told().empty());
  log.replace({finding("a", 1)}, 7);
  log.replace({finding("a", 2), finding("b")}, 11);
  log.replace({finding("b")}, 15);
  EXPECT_EQ(log.current(), (std::vector<Finding>{finding("b")}));
  log.replace({finding("a", 3)}, 19);
  EXPECT_EQ(log.told(),
            (std::vector<LiveFinding>{
                {finding("a", 1), 7, 15}, {finding("b"), 11, 19}, {finding("a", 3), 19, {}}}));
  log.replace({}, 23);
  EXPECT_TRUE(log.current().empty());
  EXPECT_EQ(log.told().back().end, 23U);
}

TEST(FindingLog, ForgetsTheOldestThatHasEnded) {
  FindingLog log;
  for (std::uint64_t n = 0; n < 3 * FindingLog::most; ++n) {
    log.replace({finding("always"), finding(std::to_string(n))}, n);
  }
  EXPECT_EQ(log.told().size(), FindingLog::most);
  EXPECT_EQ(log.told().front().finding.what, "always");
  EXPECT_EQ(log.told().back().finding.what, std::to_string(3 * FindingLog::most - 1));
}

}  // namespace slipstream::finding_log_test
