#include "slipstream/view/view_source.h"

#include <fmt/format.h>

#include "slipstream/codes/registry.h"
#include "slipstream/frames/pattern_windows.h"
#include "slipstream/live/live_pipeline.h"
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

/// The one given first; others where the patterns come from a projector that may show them.
std::vector<std::pair<std::string, Strategy>> strategies_beside(const Strategy& given,
                                                                bool patterns_can_change) {
  std::vector<std::pair<std::string, Strategy>> choices{{label_of(given), given}};
  if (!patterns_can_change) return choices;
  for (const Strategy& strategy : usual_strategies()) {
    if (strategy != given) choices.emplace_back(label_of(strategy), strategy);
  }
  return choices;
}

std::vector<std::pair<std::string, std::optional<MeasuredResponse>>> gammas_beside(
    const std::optional<MeasuredResponse>& given) {
  std::vector<std::pair<std::string, std::optional<MeasuredResponse>>> choices{
      {"as at the start", given}, {"none", std::nullopt}};
  for (const double gamma : {1.4, 1.8, 2.0, 2.2, 2.4}) {
    choices.emplace_back(fmt::format("{:g}", gamma), MeasuredResponse{PowerLaw{gamma}, gamma});
  }
  return choices;
}

/// For as long as it is shown neither the cloud nor its frames return to their pools.
ShownCloud shown_cloud(const Pooled<LiveCloud>& cloud) {
  if (!cloud) return {};
  const auto share = std::make_shared<const Pooled<LiveCloud>>(cloud);
  return {.cloud = {share, &cloud->cloud},
          .frames = views_of(cloud->frames),
          .captured = cloud->newest.host_time};
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

ViewSource live_source(LivePipeline& pipeline, const EngineSetup& setup, bool patterns_can_change) {
  return {.newest = [&pipeline] { return shown_cloud(pipeline.newest()); },
          .shown = [&pipeline](const ShownCloud& cloud) { pipeline.shown(cloud.captured); },
          .statistics = [&pipeline] { return pipeline.statistics(); },
          .setup = setup,
          .change = [&pipeline](const EngineSetup& other) { pipeline.change(other); },
          .strategies = strategies_beside(setup.sequence.strategy, patterns_can_change),
          .gammas = gammas_beside(setup.scanner.photometry.response)};
}

}  // namespace slipstream::view
