#include "slipstream/reconstruct/picture_report.h"

#include <cstdint>
#include <vector>

#include "slipstream/image/quantile.h"

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

}  // namespace slipstream
