#pragma once

#include "slipstream/cloud/cloud.h"
#include "slipstream/strategy/decoded_scan.h"

namespace slipstream {

/// A scan in 3-D, with what it was made from.
struct Reconstruction {
  Cloud cloud;
  DecodedScan decoded;
};

}  // namespace slipstream
