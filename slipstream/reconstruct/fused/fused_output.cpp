#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/reconstruct/fused/fused_engine.h"

namespace slipstream {
namespace {

std::array<Image<float>*, 4> values_of(PackedPoints& points) {
  return {&points.x, &points.y, &points.z, &points.intensity};
}

}  // namespace

void prepare(const FusedOutput& output, Size size, bool doubtful) {
  if (output.cloud != nullptr) {
    Cloud& cloud = *output.cloud;
    for (Image<float>* image : {&cloud.x, &cloud.y, &cloud.z, &cloud.intensity}) {
      prepare(*image, size);
    }
    prepare(cloud.validity, size);
  }
  if (output.depth != nullptr) {
    prepare(output.depth->z, size);
    prepare(output.depth->validity, size);
  }
  if (output.points != nullptr) {
    for (Image<float>* image : values_of(*output.points)) prepare(*image, size);
  }
  if (output.maps != nullptr) {
    Maps& maps = *output.maps;
    for (Image<float>* image :
         {&maps.mean, &maps.modulation, &maps.wrapped_phase, &maps.coordinate}) {
      prepare(*image, size);
    }
    prepare(maps.fringe_order_doubt, doubtful ? size : Size{});
  }
  if (output.modulation != nullptr) prepare(*output.modulation, size);
  if (output.numbers != nullptr) prepare(*output.numbers, size);
}

void require_frames(const FrameViews& frames, const FusedStages& stages) {
  const Size camera = stages.rays.E_x.size();
  if (frames.count() != stages.frames) {
    throw Error(
        fmt::format("{} frames given; the strategy takes {}", frames.count(), stages.frames));
  }
  if (frames.size() != camera) {
    throw Error(fmt::format("frames are {}, the scanner's camera has {}; both must agree",
                            text_of(frames.size()), text_of(camera)));
  }
}

void append_packed(int first_row, std::size_t count, PackedPoints& points) {
  for (Image<float>* values : values_of(points)) {
    std::copy_n(values->row(first_row), count, values->begin() + points.count);
  }
  points.count += count;
}

}  // namespace slipstream
