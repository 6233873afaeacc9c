#include "slipstream/view/still_source.h"

#include <memory>
#include <utility>

#include "slipstream/reconstruct/engine.h"

namespace slipstream::view {
namespace {

/// A cloud and the frames that it was made of.
struct CloudOfFrames {
  Cloud cloud{};
  std::shared_ptr<const FrameSet> frames{};
};

ShownCloud reconstructed(const std::shared_ptr<const FrameSet>& frames, const EngineSetup& setup) {
  const auto made = std::make_shared<CloudOfFrames>();
  made->frames = frames;
  Engine(setup).cloud(*frames, made->cloud);
  return {.cloud = {made, &made->cloud}, .frames = *frames};
}

}  // namespace

ViewSource still_source(Cloud cloud, std::optional<Uncertainty> uncertainty) {
  ShownCloud shown{.cloud = std::make_shared<const Cloud>(std::move(cloud))};
  if (uncertainty) shown.uncertainty = std::make_shared<const Uncertainty>(*std::move(uncertainty));
  return {.newest = [shown] { return shown; }};
}

ViewSource still_source(FrameSet frames, const EngineSetup& setup) {
  const auto kept = std::make_shared<const FrameSet>(std::move(frames));
  const auto shown = std::make_shared<ShownCloud>(reconstructed(kept, setup));
  return {
      .newest = [shown] { return *shown; },
      .setup = setup,
      .change = [kept, shown](const EngineSetup& other) { *shown = reconstructed(kept, other); }};
}

}  // namespace slipstream::view
