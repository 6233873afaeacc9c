// A frame source defined outside the library: it wraps a camera mounted upside down and rotates its
// frames, so that no later stage needs to know.
#include <algorithm>
#include <memory>
#include <utility>
#include <variant>

#include <gtest/gtest.h>

#include "slipstream/live_pipeline.h"
#include "slipstream/virtual_scanner.h"
#include "tests/extensions/seen.h"

namespace slipstream::own_adapter_test {

std::vector<Frame> frames_of(const FrameSet& set) {
  std::vector<Frame> frames;
  set.visit([&](const auto& views) {
    for (const auto& view : views) {
      Frame& frame = frames.emplace_back(FrameFormat{set.size(), set.bits()});
      frame.stamp.pattern_index = static_cast<int>(frames.size()) - 1;
      std::visit(
          [&](auto& pixels) {
            for (int row = 0; row < view.height(); ++row)
              std::copy_n(view.row(row), view.width(), pixels.row(row));
          },
          frame.pixels);
    }
  });
  return frames;
}

void turn_over(Frame& frame) {
  std::visit([](auto& pixels) { std::reverse(pixels.begin(), pixels.end()); }, frame.pixels);
}

/// Another source's frames, turned by 180 degrees.
class TurnedSource : public FrameSource {
 public:
  explicit TurnedSource(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  [[nodiscard]] FrameFormat format() const override { return source_->format(); }
  [[nodiscard]] bool has_own_pace() const override { return source_->has_own_pace(); }
  void start() override { source_->start(); }
  void stop() override { source_->stop(); }
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override {
    const Arrival arrival = source_->next(frame, timeout);
    if (arrival == Arrival::frame) turn_over(frame);
    return arrival;
  }
  [[nodiscard]] SourceCounters counters() const override { return source_->counters(); }
  [[nodiscard]] std::string state() const override { return source_->state(); }

 private:
  std::unique_ptr<FrameSource> source_;
};

TEST(FrameAdapter, OwnFrameAdapterStandsBeforeTheLivePipeline) {
  const Seen seen = seen_under(DualFrequency{}, {.clean = CleanSettings::none()});
  Cloud expected;
  Engine(seen.setup).cloud(seen.scan.frames, expected);

  std::vector<Frame> frames = frames_of(seen.scan.frames);
  for (Frame& frame : frames) turn_over(frame);
  const auto count = static_cast<std::uint64_t>(frames.size());
  Cloud live;
  LivePipeline pipeline(
      std::make_unique<TurnedSource>(std::make_unique<VirtualCamera>(std::move(frames))),
      seen.setup,
      {.most_frames = count, .on_cloud = [&](const auto& made) { live = made->cloud; }});
  pipeline.start();
  pipeline.wait();
  pipeline.stop();
  EXPECT_GT(point_count(live), 1500U);
  EXPECT_TRUE(std::equal(live.validity.begin(), live.validity.end(), expected.validity.begin()));
}

}  // namespace slipstream::own_adapter_test
