#include "slipstream/reconstruct/reconstructor.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "slipstream/reconstruct/double_reconstructor.h"

namespace slipstream {
namespace {

Image<double> widened(const Image<float>& image) {
  Image<double> wide(image.size());
  std::copy(image.begin(), image.end(), wide.begin());
  return wide;
}

Cloud fused_cloud(const FusedReconstructor& reconstruct, const FrameSet& frames) {
  FusedCloud points;
  reconstruct(frames, points);
  return cloud_of(points);
}

Reconstruction reconstruct_fused(const FusedReconstructor& reconstruct, const FrameSet& frames) {
  FusedDecoding decoding;
  reconstruct(frames, decoding);
  return {fused_cloud(reconstruct, frames),
          {.mean = widened(decoding.mean),
           .modulation = widened(decoding.modulation),
           .wrapped_phase = widened(decoding.wrapped_phase),
           .fringe_order_doubt = widened(decoding.fringe_order_doubt),
           .coordinate = widened(decoding.coordinate)}};
}

}  // namespace

Cloud cloud_of(const FusedCloud& points) {
  Cloud cloud;
  cloud.x = widened(points.x);
  cloud.y = widened(points.y);
  cloud.z = widened(points.z);
  cloud.intensity = points.intensity;
  cloud.validity = points.validity;
  return cloud;
}

/// The double-precision path, whose tables take long to build: built when it is first wanted.
class Reconstructor::InDouble {
 public:
  InDouble(const Scanner& scanner, const Strategy& strategy, Axis axis,
           const ReconstructSettings& settings)
      : scanner_(scanner), strategy_(strategy), axis_(axis), settings_(settings) {}

  const DoubleReconstructor& operator()() {
    std::call_once(once_, [this] { built_.emplace(scanner_, strategy_, axis_, settings_); });
    return *built_;
  }

 private:
  Scanner scanner_;
  Strategy strategy_;
  Axis axis_;
  ReconstructSettings settings_;
  std::once_flag once_;
  std::optional<DoubleReconstructor> built_;
};

Reconstructor::Reconstructor(const Scanner& scanner, const Strategy& strategy, Axis axis,
                             const ReconstructSettings& settings)
    : in_double_(std::make_shared<InDouble>(scanner, strategy, axis, settings)) {
  require_reconstructible(scanner, strategy, axis, settings);
  if (settings.backend == Backend::fused) {
    fused_ = FusedReconstructor::make(scanner, strategy, axis, settings);
  }
  if (!fused_) (*in_double_)();
}

bool Reconstructor::is_fused(const FrameSet& frames) const {
  return fused_ && frames.quantised();
}

Reconstruction Reconstructor::operator()(const FrameSet& frames) const {
  return is_fused(frames) ? reconstruct_fused(*fused_, frames) : (*in_double_)()(frames);
}

Cloud Reconstructor::cloud(const FrameSet& frames) const {
  return is_fused(frames) ? fused_cloud(*fused_, frames) : (*in_double_)()(frames).cloud;
}

Uncertainty Reconstructor::uncertainty(const Reconstruction& scan, const FrameSet& frames) const {
  return (*in_double_)().uncertainty(scan, frames);
}

std::string Reconstructor::backend_for(const FrameSet& frames) const {
  return is_fused(frames) ? std::string(name_of(Backend::fused))
                          : (*in_double_)().backend_for(frames);
}

}  // namespace slipstream
