#pragma once

#include <utility>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/depth_scale.h"
#include "slipstream/devices/gige_block.h"

namespace slipstream {

/// How what is sent is made of a cloud.
struct Packing {
  std::vector<std::pair<GigeComponent, GigePixels>> parts;
  DepthScale depth{};  ///< of 16 bits
  bool is_multipart = false;
};

/// One picture of a region of the cloud, as its pixels say.
void write_part(const Cloud& cloud, const Rectangle& region, const Packing& packing,
                GigePart& part);

}  // namespace slipstream
