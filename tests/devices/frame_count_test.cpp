#include <gtest/gtest.h>

#include "devices/camera_source.h"

namespace slipstream::frame_count_test {

TEST(FrameCount, GoesOnWhereNumbersOf16BitsBeginAgain) {
  FrameCount count(4);
  count.begin(1);
  std::uint64_t number = 1;
  for (std::uint64_t i = 0; i < 200000; ++i) {
    if (i % 1000 != 500) {  // drop some frames
      ASSERT_EQ(count(number), i);
    }
    number = number == 65535 ? 1 : number + 1;
  }
  EXPECT_EQ(count.missing(), 200U);
}

TEST(FrameCount, WhatIsLostBeforeTheFirstFrameIsNotMissing) {
  FrameCount count(4);
  count.begin(1);
  EXPECT_EQ(count(3), 2U);
  EXPECT_EQ(count.missing(), 0U);
  EXPECT_EQ(count(6), 5U);
  EXPECT_EQ(count.missing(), 2U);
}

TEST(FrameCount, LongNumbersDoNotWrap) {
  FrameCount count(4);
  count.begin(0);
  for (std::uint64_t i = 0; i < 200000; i += 7) ASSERT_EQ(count(i), i);
  EXPECT_EQ(count((1ULL << 40) + 3), (1ULL << 40) + 3);
}

TEST(FrameCount, LateFramesKeepTheirPlace) {
  FrameCount count(1);
  count.begin(1);
  EXPECT_EQ(count(65534), 65533U);
  EXPECT_EQ(count(2), 65536U);
  EXPECT_EQ(count(65535), 65534U);
  EXPECT_EQ(count(3), 65537U);
}

TEST(FrameCount, AfterAnInterruptionItIsAtTheFirstPatternAgainWithAGap) {
  for (std::uint64_t taken = 1; taken < 20; ++taken) {
    FrameCount count(4);
    count.begin(1);
    std::uint64_t newest = 0;
    for (std::uint64_t i = 1; i <= taken; ++i) newest = count(i);
    count.begin(1);
    const std::uint64_t first = count(1);
    EXPECT_EQ(first % 4, 0U) << taken;
    EXPECT_GT(first, newest + 1) << taken;
    EXPECT_LT(first, newest + 7) << taken;
  }
}

TEST(FrameCount, NoticesACameraThatBeginsAnew) {
  FrameCount count(3);
  count.begin(1);
  EXPECT_EQ(count(5000), 4999U);
  EXPECT_EQ(count(1), 5001U);
  EXPECT_EQ(count(2), 5002U);
}

TEST(FrameCount, NoticesACameraThatBeginsAnewBelowItsFirstNumber) {
  for (const std::uint64_t again : {1U, 4500U, 4999U}) {
    FrameCount count(3);
    count.begin(5000);
    EXPECT_EQ(count(5000), 0U);
    EXPECT_EQ(count(again), 3U) << again;
    EXPECT_EQ(count(again + 1), 4U) << again;
  }
}

}  // namespace slipstream::frame_count_test
