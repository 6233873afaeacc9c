#include "slipstream/image.h"

#include <atomic>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/parallel_rows.h"
#include "base/statistics.h"

namespace slipstream::image_test {

TEST(Image, StartsFilledAndAligned) {
  const Image<float> image({7, 3}, 2.5F);
  EXPECT_EQ(image.pixel_count(), 21U);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(image.begin()) % 64, 0U);
  for (const float pixel : image) EXPECT_EQ(pixel, 2.5F);
}

TEST(Image, CopiesAreIndependentAndMovesLeaveNothing) {
  Image<int> image({2, 2}, 1);
  Image<int> copy = image;
  copy(1, 1) = 5;
  EXPECT_EQ(image(1, 1), 1);
  const Image<int> moved = std::move(copy);
  EXPECT_EQ(moved(1, 1), 5);
  EXPECT_TRUE(copy.empty());  // NOLINT(bugprone-use-after-move): the empty state is promised
}

TEST(Image, AssignmentFillsTheMemoryThatIsThereWhereTheSizeIsTheSame) {
  const Image<int> image({2, 2}, 1);
  Image<int> same({2, 2}), other({5, 1});
  const int* const memory = same.begin();
  same = image;
  EXPECT_EQ(same.begin(), memory);
  EXPECT_EQ(same(1, 1), 1);
  other = image;
  EXPECT_EQ(other.size(), image.size());
  EXPECT_EQ(other(1, 1), 1);
}

TEST(Image, EmptyImageHasNoPixels) {
  const Image<int> image;
  EXPECT_TRUE(image.empty());
  EXPECT_EQ(image.begin(), image.end());
}

TEST(ImageView, WalksRowsByStride) {
  std::vector<int> memory{0, 1, 2, 3, 4, 5, 6, 7};
  const ImageView<int> view(memory.data() + 1, {2, 2}, 4);
  EXPECT_EQ(view(0, 0), 1);
  EXPECT_EQ(view(1, 1), 6);
  view(0, 1) = 9;
  EXPECT_EQ(memory[5], 9);
  const ImageView<const int> reading = view;
  EXPECT_EQ(reading(0, 1), 9);
}

TEST(Image, ForEachRowVisitsEveryRowOnceAndPassesOnExceptions) {
  std::vector<std::atomic<int>> visits(1000);
  for_each_row(1000, [&](int row) { ++visits[static_cast<std::size_t>(row)]; });
  for (const auto& count : visits) EXPECT_EQ(count, 1);
  EXPECT_THROW(for_each_row(10, [](int) { throw std::runtime_error("row"); }), std::runtime_error);
}

TEST(Image, QuantileIsTheValueWithThatShareBelow) {
  std::vector<float> values{5, 1, 4, 2, 3};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.25), 2);
  EXPECT_EQ(quantile(values, 0.5), 3);
  EXPECT_EQ(quantile(values, 1), 5);
  std::vector<int> even{1, 2, 3, 4}, one{7};
  EXPECT_EQ(quantile(even, 0.5), 3);
  EXPECT_EQ(quantile(one, 0.99), 7);
}

TEST(Image, FiniteValuesLeaveOutWhatIsNotANumber) {
  Image<float> image({2, 2}, 1);
  image(0, 0) = std::numeric_limits<float>::quiet_NaN();
  image(1, 0) = std::numeric_limits<float>::infinity();
  image(1, 1) = 2;
  EXPECT_EQ(finite_values(image), (std::vector<float>{1, 2}));
  EXPECT_EQ(finite_values(image, 2), std::vector<float>{1});
  EXPECT_TRUE(finite_values(Image<double>()).empty());
}

}  // namespace slipstream::image_test
