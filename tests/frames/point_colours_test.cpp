#include "frames/point_colours.h"

#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "slipstream/error.h"

namespace slipstream::point_colours_test {

/// A picture of one colour.
Image<std::uint8_t> plain(std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  Image<std::uint8_t> picture({3 * 4, 3});
  for (std::size_t i = 0; i < picture.pixel_count(); i += 3) {
    picture.begin()[i] = red;
    picture.begin()[i + 1] = green;
    picture.begin()[i + 2] = blue;
  }
  return picture;
}

TEST(PointColoursColourMean, IsThatOfItsPictures) {
  ColourMean mean;
  mean.add(plain(10, 100, 200));
  mean.add(plain(20, 100, 230));
  const Image<ColourLevels> levels = mean.levels(255);
  ASSERT_EQ(levels.size(), (Size{4, 3}));
  EXPECT_NEAR(levels(3, 2)[0], 15, 1e-4);
  EXPECT_NEAR(levels(3, 2)[1], 100, 1e-4);
  EXPECT_NEAR(levels(3, 2)[2], 215, 1e-4);
}

TEST(PointColoursColourMean, OfGreyPicturesIsEmpty) {
  ColourMean mean;
  EXPECT_TRUE(mean.levels(255).empty());
  mean.add(plain(80, 80, 80));
  EXPECT_TRUE(mean.levels(255).empty());
}

TEST(PointColoursWhiteBalance, MakesThePatchGreyAndKeepsTheBrightestColour) {
  ColourMean mean;
  mean.add(plain(100, 200, 50));
  const Image<ColourLevels> levels = mean.levels(255);
  const WhiteBalance balance = white_balance(levels, {1, 1, {2, 2}});
  EXPECT_NEAR(balance[0], 2, 1e-6);
  EXPECT_EQ(balance[1], 1);
  EXPECT_NEAR(balance[2], 4, 1e-6);
  EXPECT_EQ(balanced(levels, balance)(0, 0), (Colour{200, 200, 200}));
}

TEST(PointColoursWhiteBalance, RefusesAPatchOutsideOrTooDarkOrSaturated) {
  const auto refusal = [](const Image<std::uint8_t>& picture, const Rectangle& patch) {
    ColourMean mean;
    mean.add(picture);
    try {
      white_balance(mean.levels(255), patch);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };

  EXPECT_NE(refusal(plain(90, 80, 70), {2, 0, {3, 1}}).find("inside"), std::string::npos);
  EXPECT_NE(refusal(plain(90, 80, 70), {0, 0, {0, 1}}).find("inside"), std::string::npos);
  EXPECT_NE(refusal(plain(90, 80, 3), {0, 0, {2, 1}}).find("3"), std::string::npos);
  EXPECT_NE(refusal(plain(255, 80, 70), {0, 0, {2, 1}}).find("255"), std::string::npos);
}

}  // namespace slipstream::point_colours_test
