#include "slipstream/reconstruct/picture_report.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "slipstream/base/statistics.h"

namespace slipstream {

PictureReport picture_report(const FrameViews& frames, const Maps& maps,
                             const ReconstructSettings& settings) {
  const auto least = static_cast<float>(least_modulation(settings, frames.full_scale()));
  const Image<std::uint8_t> saturated = saturation_mask(frames);
  PictureReport report{.validity = Image<Validity>(frames.size())};
  std::vector<float> modulations;
  for (std::size_t i = 0; i < saturated.pixel_count(); ++i) {
    const float modulation = maps.modulation.begin()[i];
    Validity& pixel = report.validity.begin()[i];
    // First, as what is saturated in all frames has no modulation either.
    if (saturated.begin()[i] != 0) {
      pixel = Validity::saturated;
    } else if (!(modulation >= least)) {
      pixel = Validity::too_dark;
    } else {
      modulations.push_back(modulation);
    }
  }
  if (!modulations.empty()) {
    report.modulation = 255 / frames.full_scale() * static_cast<double>(quantile(modulations, 0.5));
  }
  return report;
}

Image<double> measured_coordinates(Engine& engine, const FrameViews& given) {
  EngineSetup setup = engine.setup();
  raise_least_modulation(setup);
  const FrameViews& frames = engine.merged(given);
  Maps maps;
  engine.maps(frames, maps);
  Image<double> coordinate = converted<double>(maps.coordinate);
  const PictureReport report = picture_report(frames, maps, setup.settings);
  Image<std::uint8_t> left_out(frames.size()), lit(frames.size());
  std::transform(report.validity.begin(), report.validity.end(), lit.begin(),
                 [](Validity pixel) { return pixel == Validity::valid ? 1 : 0; });
  if (!maps.fringe_order_doubt.empty()) {
    left_out = unconfirmed_fringe_orders(coordinate, converted<double>(maps.fringe_order_doubt),
                                         lit, highest_frequency(setup.sequence.strategy),
                                         setup.settings.fringe_order);
  }
  for (std::size_t i = 0; i < coordinate.pixel_count(); ++i) {
    if (lit.begin()[i] == 0 || left_out.begin()[i] != 0) {
      coordinate.begin()[i] = std::numeric_limits<double>::quiet_NaN();
    }
  }
  return coordinate;
}

}  // namespace slipstream
