#include "slipstream/frame_set.h"

#include <array>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "frames/pattern_windows.h"
#include "slipstream/error.h"

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

namespace slipstream::frame_views_test {

template <class Pixel>
Frames<Pixel> views_of(const std::vector<Image<Pixel>>& images) {
  return {images.begin(), images.end()};
}

TEST(FrameSet, FrameViewsAreTheFramesWhereTheyStand) {
  const std::vector<Image<std::uint8_t>> bytes(3, Image<std::uint8_t>({4, 2}, 7));
  const FrameViews views(views_of(bytes));
  EXPECT_EQ(views.count(), 3);
  EXPECT_EQ(views.size(), (Size{4, 2}));
  EXPECT_EQ(views.bits(), 8);
  EXPECT_EQ(views.full_scale(), 255);
  EXPECT_TRUE(views.quantised());
  views.visit([&](const auto& frames) {
    EXPECT_EQ(static_cast<const void*>(frames[2].row(0)),
              static_cast<const void*>(bytes[2].begin()));
  });

  const std::vector<Image<std::uint16_t>> words(2, Image<std::uint16_t>({4, 2}, 7));
  EXPECT_EQ(FrameViews(views_of(words), 12).full_scale(), 4095);
  const std::vector<Image<double>> unquantised(2, Image<double>({4, 2}, 7));
  EXPECT_FALSE(FrameViews(views_of(unquantised)).quantised());
  EXPECT_EQ(FrameViews(views_of(unquantised)).full_scale(), 255);
  EXPECT_EQ(FrameViews().count(), 0);
  EXPECT_EQ(FrameViews().size(), Size{});
}

TEST(FrameSet, FrameViewsRefuseFramesThatAreNoScan) {
  const std::vector<Image<std::uint8_t>> bytes{Image<std::uint8_t>({4, 2}),
                                               Image<std::uint8_t>({4, 3})};
  EXPECT_THROW(FrameViews(views_of(bytes)), Error);
  const std::vector<Image<std::uint16_t>> words(2, Image<std::uint16_t>({4, 2}));
  for (const int bits : {7, 17}) EXPECT_THROW(FrameViews(views_of(words), bits), Error) << bits;
}

TEST(FrameSet, FrameViewsGiveAPartInOrder) {
  std::vector<Image<std::uint16_t>> words;
  for (std::uint16_t n = 0; n < 5; ++n) words.emplace_back(Size{2, 1}, n);
  const FrameViews part = FrameViews(views_of(words), 10).part(1, 3);
  EXPECT_EQ(part.bits(), 10);
  EXPECT_EQ(part.count(), 3);
  part.visit([](const auto& frames) {
    EXPECT_EQ(frames.front()(0, 0), 1);
    EXPECT_EQ(frames.back()(1, 0), 3);
  });
}

TEST(FrameSet, FrameViewsAreWeighedAndAskedForTheirEnds) {
  std::vector<Image<std::uint8_t>> bytes(3, Image<std::uint8_t>({3, 1}, 10));
  bytes[1](1, 0) = 255;
  bytes[2](2, 0) = 0;
  const FrameViews views(views_of(bytes));
  const Image<double> sums = weighted_sum(views, {2, -1, 0.5});
  EXPECT_DOUBLE_EQ(sums(0, 0), 15);
  EXPECT_DOUBLE_EQ(sums(1, 0), 20 - 255 + 5);
  EXPECT_DOUBLE_EQ(sums(2, 0), 10);
  EXPECT_DOUBLE_EQ(weighted_sum(views, {0.5, 0.5})(1, 0), 132.5) << "of the first two";
  const Image<std::uint8_t> saturated = saturation_mask(views), unclipped = unclipped_mask(views);
  for (const auto& [column, is_saturated, is_unclipped] :
       {std::array{0, 0, 1}, {1, 1, 0}, {2, 0, 0}}) {
    EXPECT_EQ(saturated(column, 0), is_saturated);
    EXPECT_EQ(unclipped(column, 0), is_unclipped);
  }
}

}  // namespace slipstream::frame_views_test
