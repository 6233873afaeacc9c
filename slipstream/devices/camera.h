#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>

#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// How a camera lays its pixels out in memory, rows without gaps. Names are GenICam's.
enum class PixelFormat {
  mono8,   ///< a byte
  mono10,  ///< two bytes, the low one first, as with mono12 and mono16
  mono12,
  mono16,
  mono10p,        ///< bit behind bit, the low ones first: 4 pixels in 5 bytes
  mono12p,        ///< bit behind bit, the low ones first: 2 pixels in 3 bytes
  mono10_packed,  ///< 2 pixels in 3 bytes: high bits, the low bits of both, high bits
  mono12_packed,  ///< 2 pixels in 3 bytes: high bits, the low bits of both, high bits
  rgb8,           ///< in colour: a byte each for red, green and blue
};

/// "Mono8", "Mono10", ..., "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed", "RGB8".
std::string_view name_of(PixelFormat format);
std::vector<std::string_view> pixel_format_names();

/// The format of that name. Throws Error for another.
PixelFormat pixel_format_named(std::string_view name);

/// 8, 10, 12 or 16.
int bits_of(PixelFormat format);

/// Of a pixel: 3 in colour, else 1. So many times as wide are frames of it.
int values_of(PixelFormat format);

/// Bytes of a picture of so many values.
std::size_t bytes_of(PixelFormat format, std::size_t values);

/// Unpacks a picture into `frame`, of its size and bits. False, unchanged, if bytes are missing.
bool unpack(PixelFormat format, std::span<const std::uint8_t> bytes, Frame& frame);

/// What a camera is set to, as far as given. V4L2 cameras take less, as said at each.
struct CameraSettings {
  std::optional<double> exposure;    ///< s; turns automatic exposure off
  std::optional<double> gain;        ///< in the camera's unit, mostly dB; V4L2: rounded
  std::optional<double> frame_rate;  ///< Hz, of a camera that runs freely; V4L2: the nearest
  /// V4L2: begins at 0, 0, and is 640x480 where not given.
  std::optional<Rectangle> region;
  /// V4L2: mono8 (the driver's GREY, or the luma of its YUYV), mono10 (Y10), mono12 (Y12) or
  /// rgb8 (RGB24). Frames in colour are three times as wide as the region: see ColourSource.
  PixelFormat pixel_format = PixelFormat::mono8;
  /// Empty: runs freely, as V4L2 must; "Software": FrameSource::trigger; or a line, as "Line1".
  std::string trigger;
  int packet_size = 0;  ///< GigE Vision alone, bytes; 0: the largest that passes
  /// Patterns in a scan. Frames of a camera that is back are counted on from a multiple of it.
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

/// Opens a camera by name: "aravis:NAME", see open_genicam_camera, or "v4l2:NUMBER" for
/// /dev/video<NUMBER>. Throws Error for another name, a setting that the camera does not take, or
/// GenICam cameras in builds without Aravis; WorldError if the camera does not answer.
std::unique_ptr<FrameSource> open_camera(const std::string& name, const CameraSettings& settings);

/// Cameras that answer, named as open_camera takes them. Takes about a second.
std::vector<CameraDescription> list_cameras();

/// Opens the GenICam camera of that name (see list_genicam_cameras), serial number or network
/// address; the first one found if empty. Frames are numbered by the camera, from 0 at the start,
/// and timed by its clock. A camera that is gone is sought until it is back; letting go of one that
/// is gone takes seconds. Throws Error for a refused setting, WorldError without an answer.
std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name,
                                                 const CameraSettings& settings);

/// GenICam cameras that answer, on all networks and USB. Takes a second. None without Aravis.
std::vector<CameraDescription> list_genicam_cameras();

/// The system calls of a V4L2 driver, or of a camera that a test makes up; with their errno.
class VideoDevice {
 public:
  virtual ~VideoDevice() = default;
  /// ioctl: 0, or -1 and errno.
  virtual int control(unsigned long request, void* argument) = 0;
  /// Memory of the driver's, null where it fails; unmapped with `unmap`.
  virtual void* map(std::size_t length, std::size_t offset) = 0;
  virtual void unmap(void* memory, std::size_t length) = 0;
  /// Whether there is something to fetch, or an error to hear of, within that time.
  virtual bool wait(std::chrono::milliseconds timeout) = 0;
};

/// The device of that path, as /dev/video0. Throws WorldError where it cannot be opened.
std::unique_ptr<VideoDevice> open_video_device(const std::string& path);

/// Opens a camera through V4L2; `name` is what messages call it. Sequence and device time are the
/// driver's, so that frames which it dropped are seen. A camera that was unplugged is opened again
/// when it is back. Throws Error if it refuses a setting, WorldError if it does not answer.
std::unique_ptr<FrameSource> open_v4l2_camera(
    const std::string& name, const std::function<std::unique_ptr<VideoDevice>()>& open,
    const CameraSettings& settings);

/// Cameras of this machine; their names are numbers.
std::vector<CameraDescription> list_v4l2_cameras();

}  // namespace slipstream
