#include "frames/paired_source.h"

#include <gtest/gtest.h>

#include "slipstream/error.h"

namespace slipstream::paired_source_test {

/// Frames with these sequence numbers, which are also their grey levels.
class Numbered : public FrameSource {
 public:
  explicit Numbered(std::vector<int> numbers, Size size = {4, 3}, int bits = 8)
      : numbers_(std::move(numbers)), format_{size, bits} {}

  [[nodiscard]] FrameFormat format() const override { return format_; }
  [[nodiscard]] bool has_own_pace() const override { return false; }
  void start() override { next_ = 0; }
  Arrival next(Frame& frame, std::chrono::milliseconds) override {
    if (next_ == numbers_.size()) return Arrival::ended;
    const int number = numbers_[next_++];
    frame = Frame(format_);
    std::get<Image<std::uint8_t>>(frame.pixels) =
        Image<std::uint8_t>(format_.size, static_cast<std::uint8_t>(number));
    frame.stamp.sequence = static_cast<std::uint64_t>(number);
    frame.stamp.pattern_index = pattern_of ? std::optional(pattern_of(number)) : std::nullopt;
    return Arrival::frame;
  }
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override { return {.delivered = next_}; }
  [[nodiscard]] std::string state() const override { return {}; }

  std::function<int(int)> pattern_of;

 private:
  std::vector<int> numbers_;
  FrameFormat format_;
  std::size_t next_ = 0;
};

int level(const std::variant<Image<std::uint8_t>, Image<std::uint16_t>>& pixels) {
  return std::get<Image<std::uint8_t>>(pixels)(0, 0);
}

TEST(PairedSource, PairsEqualNumbersAndDropsTheOthers) {
  PairedSource pairs(std::make_unique<Numbered>(std::vector{0, 1, 2, 4, 5, 7}),
                     std::make_unique<Numbered>(std::vector{1, 2, 3, 4, 6, 7}, Size{2, 5}));
  pairs.start();
  std::vector<int> numbers;
  Frame frame(pairs.format());
  while (pairs.next(frame, std::chrono::milliseconds(1)) == Arrival::frame) {
    numbers.push_back(static_cast<int>(frame.stamp.sequence));
    EXPECT_EQ(level(frame.pixels), numbers.back());
    EXPECT_EQ(level(frame.second), numbers.back());
    EXPECT_EQ(std::get<Image<std::uint8_t>>(frame.second).size(), (Size{2, 5}));
  }
  EXPECT_EQ(numbers, (std::vector{1, 2, 4, 7}));
  EXPECT_EQ(pairs.counters().delivered, 4U);
}

TEST(PairedSource, NeverCombinesDifferentPatterns) {
  auto first = std::make_unique<Numbered>(std::vector{0, 1, 2});
  auto second = std::make_unique<Numbered>(std::vector{0, 1, 2});
  first->pattern_of = [](int number) { return number; };
  second->pattern_of = [](int number) { return number == 1 ? 2 : number; };
  PairedSource pairs(std::move(first), std::move(second));
  pairs.start();
  Frame frame(pairs.format());
  const auto next = [&] { return pairs.next(frame, std::chrono::milliseconds(1)); };
  EXPECT_EQ(next(), Arrival::frame);
  EXPECT_EQ(next(), Arrival::damaged);
  EXPECT_EQ(next(), Arrival::frame);
  EXPECT_EQ(frame.stamp.sequence, 2U);
}

TEST(PairedSource, RefusesDifferentBits) {
  EXPECT_THROW(PairedSource(std::make_unique<Numbered>(std::vector{0}),
                            std::make_unique<Numbered>(std::vector{0}, Size{4, 3}, 12)),
               Error);
}

}  // namespace slipstream::paired_source_test
