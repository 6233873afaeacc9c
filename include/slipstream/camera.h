#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/frame_source.h"

namespace slipstream {

/// Memory layout of a camera's pixels, rows without gaps. Names are GenICam's.
enum class PixelFormat {
  mono8,   ///< one byte
  mono10,  ///< two bytes, low byte first, as in mono12 and mono16
  mono12,
  mono16,
  mono10p,        ///< packed, low bits first: 4 pixels in 5 bytes
  mono12p,        ///< packed, low bits first: 2 pixels in 3 bytes
  mono10_packed,  ///< 2 pixels in 3 bytes: high bits, the low bits of both, high bits
  mono12_packed,  ///< 2 pixels in 3 bytes: high bits, the low bits of both, high bits
  rgb8,           ///< colour: one byte each for red, green and blue
  mjpg,           ///< V4L2 only: JPEG, decoded to its luminance
};

/// "Mono8", "Mono10", ..., "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed", "RGB8", "MJPG".
std::string_view name_of(PixelFormat format);
std::vector<std::string_view> pixel_format_names();

/// The format of that name. Throws Error if unknown.
PixelFormat pixel_format_named(std::string_view name);

/// 8, 10, 12 or 16.
int bits_of(PixelFormat format);

/// Values per pixel: 3 for colour, else 1. Frames are this many times as wide as the region.
int values_of(PixelFormat format);

/// Bytes of a picture with this many values.
std::size_t bytes_of(PixelFormat format, std::size_t values);

/// Unpacks a picture into `frame` of its size and bit depth. Returns false, leaving `frame`
/// unchanged, if bytes are missing.
bool unpack(PixelFormat format, std::span<const std::uint8_t> bytes, Frame& frame);

/// A GenICam node and its value as text, e.g. LineSource and ExposureActive.
struct CameraNode {
  std::string name, value;
};

/// Camera settings, each optional. V4L2 cameras support fewer, as noted.
struct CameraSettings {
  std::optional<double> exposure;    ///< s; turns automatic exposure off
  std::optional<double> gain;        ///< in the camera's unit, usually dB; V4L2: rounded
  std::optional<double> frame_rate;  ///< Hz, free-running cameras only; V4L2: the nearest rate
  /// V4L2: starts at 0, 0; default 640x480.
  std::optional<Rectangle> region;
  /// V4L2: mono8 (the driver's GREY, or the luma of YUYV), mono10 (Y10), mono12 (Y12) or rgb8
  /// (RGB24). Colour frames are three times as wide as the region: see ColourSource.
  PixelFormat pixel_format = PixelFormat::mono8;
  /// Bayer filters: "RG", "GR", "GB" or "BG"; empty for a sensor without.
  std::string mosaic{};
  bool keep_mosaic = false;  ///< delivers the values of the filters as they are, instead of grey
  /// Empty: free-running, the only mode of V4L2; "Software": FrameSource::trigger; or a line, e.g.
  /// "Line1".
  std::string trigger;
  /// Output line that is active during each exposure and advances the projector, e.g. "Line1";
  /// empty: none. GenICam only, like its delay (from the start of the exposure to a pulse, s).
  std::string strobe;
  std::optional<double> strobe_delay;
  bool strobe_inverted = false;  ///< low during the exposure
  /// GenICam only: nodes to set, in this order, after trigger and strobe. Commands are executed.
  std::vector<CameraNode> nodes;
  /// Called on opening for each node of the strobe and `nodes`, with the value read back.
  std::function<void(const CameraNode&)> node_set;
  int packet_size = 0;  ///< GigE Vision only, bytes; 0: the largest the network passes
  /// Patterns per scan. After a reconnection, frames are counted on from a multiple of it.
  int cycle = 1;
};

/// "Mono12p", or "BayerRG12p" with a mosaic.
std::string pixel_format_of(const CameraSettings& settings);
/// Sets pixel format and mosaic by that name. Throws Error if unknown.
void set_pixel_format(CameraSettings& settings, const std::string& name);

/// A camera found by a search.
struct CameraDescription {
  std::string name;  ///< name to open it
  std::string vendor, model, serial;
  std::string address;   ///< its address on the network or bus
  std::string protocol;  ///< "GigEVision", "USB3Vision", "V4L2"
};

/// Opens a camera by name: "aravis:NAME" for the GenICam camera of that name, serial number or
/// network address, or the first one found if NAME is empty, or "v4l2:NUMBER" for
/// /dev/video<NUMBER>. A lost camera is searched for until it is back. Throws Error for other
/// names, a refused setting, or a GenICam camera in a build without Aravis; WorldError if the
/// camera does not answer.
std::unique_ptr<FrameSource> open_camera(const std::string& name, const CameraSettings& settings);

/// Cameras that answer, by their names for open_camera. Takes about a second.
std::vector<CameraDescription> list_cameras();

}  // namespace slipstream
