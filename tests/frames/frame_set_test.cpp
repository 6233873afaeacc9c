#include "slipstream/frames/frame_set.h"

#include <utility>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"

namespace slipstream::frame_set_test {

TEST(FrameSet, RefusesFramesOfDifferentSizes) {
  FrameSet::Images8 images;
  images.emplace_back(Size{4, 3});
  images.emplace_back(Size{4, 2});
  EXPECT_THROW(FrameSet{images}, Error);
  EXPECT_THROW(FrameSet(FrameSet::Images16{Image<std::uint16_t>({4, 3})}, 17), Error);
}

TEST(FrameSet, VisitsAPartInOrder) {
  FrameSet::Images8 images;
  for (std::uint8_t n = 0; n < 5; ++n) images.emplace_back(Size{2, 1}, n);
  const FrameSet frames(images);
  frames.views().part(1, 3).visit([](const auto& views) {
    ASSERT_EQ(views.size(), 3U);
    EXPECT_EQ(views[0](0, 0), 1);
    EXPECT_EQ(views[2](1, 0), 3);
  });
}

TEST(FrameSet, KnowsFullScaleAndSaturation) {
  FrameSet::Images16 images(2, Image<std::uint16_t>({3, 1}, 100));
  images[1](2, 0) = 1023;
  const FrameSet frames(images, 10);
  EXPECT_EQ(frames.full_scale(), 1023);
  const Image<std::uint8_t> saturated = saturation_mask(frames);
  EXPECT_EQ(saturated(0, 0), 0);
  EXPECT_EQ(saturated(2, 0), 1);

  const FrameSet unquantised(FrameSet::ImagesUnquantised{Image<double>({2, 2}, 300.0)});
  EXPECT_FALSE(unquantised.quantised());
  EXPECT_EQ(saturation_mask(unquantised)(0, 0), 0);
}

TEST(FrameSet, IsReorderedWithoutACopy) {
  FrameSet::Images16 images;
  for (std::uint16_t n = 0; n < 3; ++n) images.emplace_back(Size{2, 1}, n);
  FrameSet frames(images, 12);
  const auto pixels_of = [](const FrameSet& set, std::size_t n) -> const void* {
    return set.visit([n](const auto& views) -> const void* { return &views[n](0, 0); });
  };
  const void* const first = pixels_of(frames, 0);
  const FrameSet ordered = reordered(std::move(frames), {2, 0, 1});
  EXPECT_EQ(ordered.bits(), 12);
  EXPECT_EQ(pixels_of(ordered, 1), first);
  ordered.visit([](const auto& views) {
    ASSERT_EQ(views.size(), 3U);
    EXPECT_EQ(views[0](0, 0), 2);
    EXPECT_EQ(views[1](0, 0), 0);
    EXPECT_EQ(views[2](1, 0), 1);
  });
}

TEST(FrameSet, RefusesWhatIsNoOrder) {
  const FrameSet frames(FrameSet::Images8(3, Image<std::uint8_t>({2, 1})));
  for (const std::vector<int>& order :
       std::vector<std::vector<int>>{{}, {0, 1}, {0, 1, 1}, {0, 1, 3}, {-1, 0, 1}, {0, 1, 2, 3}}) {
    EXPECT_THROW((void)reordered(frames, order), Error);
  }
  EXPECT_EQ(reordered(frames, {0, 1, 2}).count(), 3);
}

}  // namespace slipstream::frame_set_test
