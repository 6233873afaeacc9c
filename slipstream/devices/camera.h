#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/base/size.h"
#include "slipstream/devices/pixel_format.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// What a camera is set to; what is not given stays as the camera has it. Cameras of V4L2 take less
/// than those of GenICam, as said at each.
struct CameraSettings {
  std::optional<double> exposure;    ///< s; turns automatic exposure off
  std::optional<double> gain;        ///< in the camera's unit, mostly dB; V4L2: rounded
  std::optional<double> frame_rate;  ///< Hz, of a camera that runs freely; V4L2: the nearest
  /// V4L2: begins at 0, 0, and is 640x480 where not given.
  std::optional<Rectangle> region;
  /// V4L2: mono8 (the driver's GREY, or the luma of its YUYV), mono10 (Y10), mono12 (Y12) or
  /// rgb8 (RGB24). Frames in colour are three times as wide as the region: see ColourSource.
  PixelFormat pixel_format = PixelFormat::mono8;
  /// What starts each frame: empty: the camera runs freely, as V4L2 must; "Software":
  /// FrameSource::trigger; or the camera's name of a line, as "Line1".
  std::string trigger;
  int packet_size = 0;  ///< GigE Vision alone, bytes; 0: the largest that passes
  /// Patterns in a scan. When a camera was gone and is back, the count of its frames goes on at a
  /// multiple of it.
  int cycle = 1;
};

/// A camera that was found.
struct CameraDescription {
  std::string name;  ///< opens it
  std::string vendor;
  std::string model;
  std::string serial;
  std::string address;   ///< on the network or the bus
  std::string protocol;  ///< "GigEVision", "USB3Vision", "V4L2"
};

/// Opens a camera by name: "aravis:NAME" as open_genicam_camera takes it (the first one found where
/// NAME is empty), or "v4l2:NUMBER" for /dev/video<NUMBER>. Throws Error for another name, a
/// setting that the camera does not take, or GenICam cameras in builds without Aravis; WorldError
/// where the camera does not answer.
std::unique_ptr<FrameSource> open_camera(const std::string& name, const CameraSettings& settings);

/// Cameras that answer, named as open_camera takes them. Takes about a second.
std::vector<CameraDescription> list_cameras();

/// Opens the GenICam camera of that name (see list_genicam_cameras), serial number or network
/// address; the first one found where it is empty. Frames are numbered by the camera, from 0 at the
/// start, and timed by its clock. A camera that is gone is sought until it is back; letting go of
/// one that is gone takes some seconds. Throws Error where it does not take a setting and in builds
/// without Aravis, WorldError where it does not answer.
std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name,
                                                 const CameraSettings& settings);

/// GenICam cameras that answer, on all networks and USB; their names are as they are opened
/// by. Takes about a second. None in builds without Aravis.
std::vector<CameraDescription> list_genicam_cameras();

}  // namespace slipstream
