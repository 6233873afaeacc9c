#include "frames/colour_channels.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error.h"

namespace slipstream::colour_source_test {

constexpr Size picture_size{5, 4};

std::uint8_t value(int picture, int channel, int column, int row) {
  return static_cast<std::uint8_t>(20 * channel + 7 * column + 3 * row + picture);
}

/// Pictures 0, 2, 4, ...: every other one is lost.
class Pictures : public FrameSource {
 public:
  explicit Pictures(FrameFormat format) : format_(format) {}
  [[nodiscard]] FrameFormat format() const override { return format_; }
  [[nodiscard]] bool has_own_pace() const override { return false; }
  void start() override { taken_ = 0; }
  Arrival next(Frame& frame, std::chrono::milliseconds) override {
    if (taken_ == 3) return Arrival::ended;
    const int picture = 2 * taken_++;
    auto& image = std::get<Image<std::uint8_t>>(frame.pixels);
    for (int row = 0; row < picture_size.height; ++row) {
      for (int column = 0; column < image.width(); ++column) {
        image(column, row) = value(picture, column % 3, column / 3, row);
      }
    }
    frame.stamp = {.sequence = static_cast<std::uint64_t>(picture), .pattern_index = picture % 3};
    return Arrival::frame;
  }
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override {
    return {.delivered = static_cast<std::uint64_t>(taken_), .lost = 2};
  }
  [[nodiscard]] std::string state() const override { return "well"; }

 private:
  FrameFormat format_;
  int taken_ = 0;
};

constexpr FrameFormat of_pictures{{3 * picture_size.width, picture_size.height}, 8};

TEST(ColourChannels, ColourSourceGivesTheChannelsOneAfterAnother) {
  ColourSource source(std::make_unique<Pictures>(of_pictures));
  EXPECT_EQ(source.format(), (FrameFormat{picture_size, 8}));
  for (int round = 0; round < 2; ++round) {
    source.start();
    Frame frame;
    for (int n = 0; n < 9; ++n) {
      const int picture = n / 3 * 2, channel = n % 3;
      ASSERT_EQ(source.next(frame, {}), Arrival::frame);
      EXPECT_EQ(frame.stamp.sequence, static_cast<std::uint64_t>(3 * picture + channel));
      EXPECT_EQ(frame.stamp.pattern_index, 3 * (picture % 3) + channel);
      const auto& image = std::get<Image<std::uint8_t>>(frame.pixels);
      for (int row = 0; row < picture_size.height; ++row) {
        for (int column = 0; column < picture_size.width; ++column) {
          ASSERT_EQ(image(column, row), value(picture, channel, column, row));
        }
      }
    }
    EXPECT_EQ(source.next(frame, {}), Arrival::ended);
  }
  EXPECT_EQ(source.counters().delivered, 9U);
  EXPECT_EQ(source.counters().lost, 6U);
  EXPECT_EQ(source.state(), "well");
}

constexpr ColourMixture mixture{{{1, 0.2, 0.05, 3}, {0.15, 0.9, 0.2, 2}, {0.05, 0.2, 0.75, 1}}};

/// The channels of a picture, taken apart.
FrameSet apart_of(int picture) {
  FrameSet::Images8 seen(3, Image<std::uint8_t>(picture_size));
  for (int c = 0; c < 3; ++c) {
    for (int row = 0; row < picture_size.height; ++row) {
      for (int column = 0; column < picture_size.width; ++column) {
        seen[static_cast<std::size_t>(c)](column, row) = value(picture, c, column, row);
      }
    }
  }
  return unmixed(FrameSet(seen), mixture);
}

std::string refusal(const FrameSet& frames, const FrameSet& white = {}) {
  try {
    static_cast<void>(unmixed(frames, mixture, white));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ColourChannels, UnmixedSaysWhatIsNoPicture) {
  const auto frames = [](std::size_t count, Size size) {
    return FrameSet(FrameSet::Images8(count, Image<std::uint8_t>(size)));
  };
  const FrameSet pictures = frames(6, picture_size);
  EXPECT_EQ(refusal(pictures, frames(3, picture_size)), "");
  EXPECT_EQ(refusal(frames(4, picture_size)),
            "4 frames given; expected a multiple of 3, one per channel");
  const std::string no_white = "the white picture must have three channels of the frames' size";
  EXPECT_EQ(refusal(pictures, frames(6, picture_size)), no_white);
  EXPECT_EQ(refusal(pictures, frames(3, {4, 4})), no_white);
  try {
    measured_mixture(pictures);
    FAIL() << "six frames are not four pictures";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              "6 frames given; expected 12: three channels each of black, red, green and blue");
  }
}

/// The next three frames of the source are those of that picture.
void expect_apart(FrameSource& source, int picture) {
  const FrameSet apart = apart_of(picture);
  apart.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
    std::uint64_t sequence = 3 * static_cast<std::uint64_t>(picture);
    for (const auto& one : frames) {
      Frame frame(source.format());
      ASSERT_EQ(source.next(frame, {}), Arrival::frame);
      EXPECT_EQ(frame.stamp.sequence, sequence++);
      const auto& image = std::get<Image<std::uint16_t>>(frame.pixels);
      for (int row = 0; row < picture_size.height; ++row) {
        for (int column = 0; column < picture_size.width; ++column) {
          ASSERT_EQ(image(column, row), one(column, row));
        }
      }
    }
  });
}

TEST(ColourChannels, UnmixedSourceTakesThemApart) {
  UnmixedSource source(std::make_unique<ColourSource>(std::make_unique<Pictures>(of_pictures)),
                       mixture);
  EXPECT_EQ(source.format(), (FrameFormat{picture_size, 16}));
  for (int round = 0; round < 2; ++round) {
    source.start();
    expect_apart(source, 0);
    expect_apart(source, 2);
  }
}

/// Lacks some frames of another.
class Lossy : public ColourSource {
 public:
  Lossy(std::unique_ptr<FrameSource> pictures, std::vector<std::uint64_t> lost)
      : ColourSource(std::move(pictures)), lost_(std::move(lost)) {}
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override {
    const Arrival arrival = ColourSource::next(frame, timeout);
    const bool gone = std::find(lost_.begin(), lost_.end(), frame.stamp.sequence) != lost_.end();
    return arrival == Arrival::frame && gone ? Arrival::damaged : arrival;
  }

 private:
  std::vector<std::uint64_t> lost_;
};

TEST(ColourChannels, UnmixedSourceLeavesOutPicturesThatLackAChannel) {
  // Pictures 0, 2 and 4 are frames 0 to 2, 6 to 8 and 12 to 14.
  const std::vector<std::vector<std::uint64_t>> losses{{0}, {1}, {2}, {1, 2}, {2, 6}, {0, 8}};
  for (const std::vector<std::uint64_t>& lost : losses) {
    UnmixedSource source(std::make_unique<Lossy>(std::make_unique<Pictures>(of_pictures), lost),
                         mixture);
    source.start();
    Frame frame;
    std::vector<std::uint64_t> came;
    for (Arrival arrival{}; (arrival = source.next(frame, {})) != Arrival::ended;) {
      if (arrival == Arrival::frame) came.push_back(frame.stamp.sequence);
    }
    std::vector<std::uint64_t> wanted;
    for (const std::uint64_t picture : {0U, 2U, 4U}) {
      if (std::any_of(lost.begin(), lost.end(), [&](auto n) { return n / 3 == picture; })) continue;
      for (std::uint64_t c = 0; c < 3; ++c) wanted.push_back(3 * picture + c);
    }
    EXPECT_EQ(came, wanted) << lost.front();
  }
}

TEST(ColourChannels, ColourSourceRefusesOtherFrames) {
  EXPECT_THROW(ColourSource(std::make_unique<Pictures>(FrameFormat{{16, 4}, 8})), Error);
  EXPECT_THROW(ColourSource(std::make_unique<Pictures>(FrameFormat{{15, 4}, 12})), Error);
}

}  // namespace slipstream::colour_source_test
