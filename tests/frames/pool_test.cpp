
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/frame_source.h"

namespace slipstream::pool_test {

TEST(Pool, GivesEachValueToOneTakerAndAgainAfterTheLastShare) {
  Pool<int> pool(2, [made = 0]() mutable { return ++made; });
  Pooled<int> first = pool.take();
  const Pooled<int> second = pool.take();
  ASSERT_TRUE(first && second);
  EXPECT_NE(*first, *second);
  EXPECT_FALSE(pool.take());
  const int value = *first;
  Pooled<int> copy = first;
  first = {};
  EXPECT_FALSE(pool.take());
  copy = {};
  const Pooled<int> again = pool.take();
  ASSERT_TRUE(again);
  EXPECT_EQ(*again, value);
}

TEST(Pool, SharesOutliveThePool) {
  Pooled<int> share;
  {
    Pool<int> pool(1, [] { return 7; });
    share = pool.take();
  }
  EXPECT_EQ(*share, 7);
}

TEST(Pool, TellsOfAValueOnlyWhenItsLastShareIsDropped) {
  int returned = 0;
  Pool<int> pool(
      1, [] { return 7; }, [&] { ++returned; });
  Pooled<int> share = pool.take();
  Pooled<int> copy = share;
  Pooled<int> moved = std::move(share);
  moved = {};
  EXPECT_EQ(returned, 0);
  copy = {};
  EXPECT_EQ(returned, 1);
  EXPECT_TRUE(pool.take());
  EXPECT_EQ(returned, 2);
}

TEST(Pool, ValuesPassBetweenThreads) {
  Pool<int> pool(1, [] { return 0; });
  int sum = 0;
  for (int turn = 1; turn <= 1000; ++turn) {
    Pooled<int> share = pool.take();
    while (!share) share = pool.take();
    share.fill() = turn;
    std::thread reader([&sum, read = std::move(share)]() mutable {
      sum += *read;
      read = {};
    });
    reader.join();
  }
  EXPECT_EQ(sum, 500500);
}

TEST(Pool, FrameHasThePixelsOfItsFormat) {
  const FrameFormat format{{5, 3}, 12};
  EXPECT_EQ(Frame(format).format(), format);
  EXPECT_EQ(Frame({{5, 3}, 8}).pixels.index(), 0U);
  EXPECT_THROW(Frame({{0, 3}, 8}), Error);
  EXPECT_THROW(Frame({{5, 3}, 17}), Error);
}

}  // namespace slipstream::pool_test
