#include <algorithm>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "frames/pattern_windows.h"
#include "slipstream/live_pipeline.h"
namespace slipstream::rolling_window_test {

Pooled<Frame> numbered(Pool<Frame>& pool, std::uint64_t number) {
  Pooled<Frame> frame = pool.take();
  if (frame) frame.fill().stamp.sequence = number;
  return frame;
}

/// With frames lost and the rest shuffled by up to N - 1 places, it gives every complete window in
/// order and counts the others.
RC_GTEST_PROP(RollingWindow, GivesEveryWindowWhoseFramesCame, ()) {
  const auto N = static_cast<std::uint64_t>(*rc::gen::inRange(2, 8));
  const auto seed = *rc::gen::arbitrary<unsigned>();
  std::mt19937 random(seed);
  const std::uint64_t count = 20 * N;
  std::vector<std::uint64_t> order;
  std::set<std::uint64_t> there;
  for (std::uint64_t p = 0; p < count; ++p) {
    // Keep the first and last frames, so that no window stays undecided.
    if (p >= N && p + 2 * N < count && random() % 10 == 0) continue;
    order.push_back(p);
    there.insert(p);
  }
  for (std::size_t i = N; i + 2 * N < order.size(); i += 2) {
    const std::size_t other = i + random() % 2;
    // Swap adjacent frames; a gap between them increases the delay.
    if (order[other] - order[i] < N) std::swap(order[i], order[other]);
  }

  Pool<Frame> pool(4 * N, [] { return Frame(); });
  RollingWindow windows(static_cast<int>(N), static_cast<int>(N));
  std::vector<std::uint64_t> given;
  std::vector<Pooled<Frame>> window;
  for (const std::uint64_t p : order) {
    RC_ASSERT(windows.put(p, numbered(pool, p)));
    while (windows.next(window)) {
      std::uint64_t newest = 0;
      for (std::uint64_t n = 0; n < N; ++n) {
        RC_ASSERT(window[n]->stamp.sequence % N == n);
        newest = std::max(newest, window[n]->stamp.sequence);
      }
      for (const auto& frame : window) RC_ASSERT(frame->stamp.sequence + N > newest);
      given.push_back(newest);
    }
  }
  std::vector<std::uint64_t> expected;
  for (std::uint64_t last = N - 1; last < count; ++last) {
    bool whole = true;
    for (std::uint64_t back = 0; back < N; ++back) whole = whole && there.count(last - back) == 1;
    if (whole) expected.push_back(last);
  }
  RC_ASSERT(given == expected);
  RC_ASSERT(windows.lost() == count - (N - 1) - expected.size());
}

TEST(RollingWindow, ALongGapCostsNothingButTheWindows) {
  Pool<Frame> pool(16, [] { return Frame(); });
  RollingWindow windows(4, 4);
  std::vector<Pooled<Frame>> window;
  for (std::uint64_t p = 0; p < 4; ++p) windows.put(p, numbered(pool, p));
  EXPECT_TRUE(windows.next(window));
  const std::uint64_t far = 1'000'000'000'000;
  for (std::uint64_t p = far; p < far + 4; ++p) {
    EXPECT_FALSE(windows.next(window));
    windows.put(p, numbered(pool, p));
  }
  EXPECT_TRUE(windows.next(window));
  EXPECT_EQ(windows.lost(), far + 3 - 4);
}

TEST(RollingWindow, RefusesAFrameThatCameBefore) {
  Pool<Frame> pool(8, [] { return Frame(); });
  RollingWindow windows(3, 3);
  EXPECT_TRUE(windows.put(7, numbered(pool, 7)));
  EXPECT_FALSE(windows.put(7, numbered(pool, 7)));
  EXPECT_FALSE(windows.put(6, numbered(pool, 6)));
}

}  // namespace slipstream::rolling_window_test
