#include "slipstream/view/frame_decoding.h"

#include <algorithm>

#include "slipstream/live/window_frames.h"

namespace slipstream::view {
namespace {

Image<float> narrowed(const Image<double>& image) {
  Image<float> narrow(image.size());
  std::copy(image.begin(), image.end(), narrow.begin());
  return narrow;
}

FusedDecoding narrowed(const DecodedScan& decoded) {
  FusedDecoding narrow;
  narrow.mean = narrowed(decoded.mean);
  narrow.modulation = narrowed(decoded.modulation);
  narrow.wrapped_phase = narrowed(decoded.wrapped_phase);
  return narrow;
}

}  // namespace

void FrameDecoding::look_for(const LiveScan& scan) {
  frames_ = frame_count(scan.strategy);
  in_double_.reset();
  fused_ = FusedReconstructor::make(scan.scanner, scan.strategy, scan.axis, scan.settings);
  if (!fused_) in_double_.emplace(scan.scanner, scan.strategy, scan.axis, scan.settings);
}

const FusedDecoding* FrameDecoding::operator()(const LiveCloud& cloud) {
  if (cloud.frames.empty() || static_cast<int>(cloud.frames.size()) != frames_) return nullptr;
  const FrameSet frames = frame_set_of(cloud.frames);
  if (fused_) {
    (*fused_)(frames, decoding_);
  } else {
    decoding_ = narrowed((*in_double_)(frames).decoded);
  }
  return &decoding_;
}

}  // namespace slipstream::view
