// Your own camera: a FrameSource that fills frames, here from images in memory.
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/live_pipeline.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

using namespace slipstream;

class OwnCamera : public FrameSource {
 public:
  explicit OwnCamera(std::vector<Frame> pictures) : pictures_(std::move(pictures)) {}

  [[nodiscard]] FrameFormat format() const override { return pictures_.front().format(); }
  [[nodiscard]] bool has_own_pace() const override { return false; }
  void start() override { taken_ = 0; }
  Arrival next(Frame& frame, std::chrono::milliseconds) override {
    if (taken_ == pictures_.size()) return Arrival::ended;
    frame.pixels = pictures_[taken_].pixels;  // copy a driver's buffer here
    frame.stamp.sequence = taken_++;
    frame.stamp.host_time = std::chrono::steady_clock::now();
    return Arrival::frame;
  }
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override { return {.delivered = taken_}; }
  [[nodiscard]] std::string state() const override { return {}; }

 private:
  std::vector<Frame> pictures_;
  std::size_t taken_ = 0;
};

int main() {
  const Scanner scanner = example_scanner({320, 240});
  const Sequence sequence{.strategy = make_strategy("pmp", {{"steps", 4}})};
  auto camera = std::make_unique<OwnCamera>(virtual_frames(scanner, scene_named("sphere", scanner),
                                                           pattern_set(sequence), {.bits = 8}, 4));
  LivePipeline pipeline(std::move(camera), {scanner, sequence},
                        {.indexing = PatternIndexing::counted});
  pipeline.start();
  pipeline.wait();  // until the camera has no more frames
  pipeline.stop();
  std::printf("%llu clouds of 16 frames\n",
              static_cast<unsigned long long>(pipeline.statistics().clouds));
}
