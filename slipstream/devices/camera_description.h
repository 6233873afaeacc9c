#pragma once

#include <string>

namespace slipstream {

/// A camera that was found.
struct CameraDescription {
  std::string name;  ///< opens it
  std::string vendor;
  std::string model;
  std::string serial;
  std::string address;   ///< on the network or the bus
  std::string protocol;  ///< "GigEVision", "USB3Vision", "V4L2"
};

}  // namespace slipstream
