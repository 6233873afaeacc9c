#pragma once

#include <string>
#include <vector>

namespace slipstream {

/// A camera that was found.
struct CameraDescription {
  std::string name;  ///< opens it: AravisSource, or a number for V4l2Source
  std::string vendor;
  std::string model;
  std::string serial;
  std::string address;   ///< of the network or the bus
  std::string protocol;  ///< "GigEVision", "USB3Vision"
};

/// GenICam cameras that answer, on all networks and USB. Takes about a second.
std::vector<CameraDescription> list_genicam_cameras();

}  // namespace slipstream
