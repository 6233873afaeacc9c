#include "devices/v4l2.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <variant>
#include <vector>

#include <linux/videodev2.h>

#include "base/system_failure.h"
#include "base/throw_if-inl.h"
#include "devices/camera_source.h"
#include "frames/mosaic.h"
#ifdef SLIPSTREAM_IO
#include "io/plain_pictures.h"
#endif

namespace slipstream {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr unsigned v4l2_buffer_count = 8;

struct PixelLayout {
  std::uint32_t code;
  int bits;
  int bytes;       ///< bytes between values of a pixel
  int values = 1;  ///< bytes per pixel
  std::string_view mosaic{};
};

/// The preferred layout for each bit depth comes first.
constexpr std::array<PixelLayout, 10> layouts{{
    {V4L2_PIX_FMT_GREY, 8, 1},
    {V4L2_PIX_FMT_YUYV, 8, 2},
    {V4L2_PIX_FMT_Y10, 10, 2},
    {V4L2_PIX_FMT_Y12, 12, 2},
    {V4L2_PIX_FMT_RGB24, 8, 1, 3},
    {V4L2_PIX_FMT_MJPEG, 8, 1},
    {V4L2_PIX_FMT_SRGGB8, 8, 1, 1, "RG"},
    {V4L2_PIX_FMT_SGRBG8, 8, 1, 1, "GR"},
    {V4L2_PIX_FMT_SGBRG8, 8, 1, 1, "GB"},
    {V4L2_PIX_FMT_SBGGR8, 8, 1, 1, "BG"},
}};

template <class Structure>
Structure cleared() {
  Structure structure;
  std::memset(&structure, 0, sizeof(structure));
  structure.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  return structure;
}

std::string text_of(const std::uint8_t* letters) {
  return reinterpret_cast<const char*>(letters);
}

/// Device time; 0 (no clock) for an impossible time.
std::chrono::nanoseconds time_of(const timeval& time) {
  constexpr std::int64_t longest = std::int64_t{1} << 31;  // s: 68 years
  const bool possible = 0 <= time.tv_sec && time.tv_sec < longest && 0 <= time.tv_usec &&
                        time.tv_usec < std::micro::den;
  if (!possible) return {};
  return std::chrono::seconds(time.tv_sec) + std::chrono::microseconds(time.tv_usec);
}

/// nullopt if it is not a streaming camera.
std::optional<v4l2_capability> camera_of(VideoDevice& device) {
  v4l2_capability capability{};
  if (device.control(VIDIOC_QUERYCAP, &capability) != 0) return std::nullopt;

  // A driver with several devices lists the capabilities of this one separately.
  const std::uint32_t capabilities = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                                         ? capability.device_caps
                                         : capability.capabilities;

  constexpr std::uint32_t wanted = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  return (capabilities & wanted) == wanted ? std::optional(capability) : std::nullopt;
}

/// A V4L2 control, in integer units.
struct LightControl {
  std::uint32_t id, automatic;
  int manual;   ///< value of `automatic` that enables manual control
  double unit;  ///< size of a step in CameraControl's unit
};
constexpr LightControl exposure_control{V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CID_EXPOSURE_AUTO,
                                        V4L2_EXPOSURE_MANUAL, 0.1};
constexpr LightControl gain_control{V4L2_CID_GAIN, V4L2_CID_AUTOGAIN, 0, 1};

bool put_control(VideoDevice& device, std::uint32_t id, int value) {
  v4l2_control control{id, value};
  return device.control(VIDIOC_S_CTRL, &control) == 0;
}

/// Rows of pixels, `row_bytes` apart, `pixel_bytes` per pixel.
template <class Pixel>
void copy_rows(const std::uint8_t* bytes, std::size_t row_bytes, std::size_t pixel_bytes,
               Image<Pixel>& image) {
  for (int row = 0; row < image.height(); ++row, bytes += row_bytes) {
    Pixel* to = image.row(row);
    // Without bytes in between, a row is copied whole; otherwise every first byte of a pixel.
    if (pixel_bytes == sizeof(Pixel)) {
      std::memcpy(to, bytes, static_cast<std::size_t>(image.width()) * sizeof(Pixel));
      continue;
    }
    for (int column = 0; column < image.width(); ++column) {
      to[column] = bytes[static_cast<std::size_t>(column) * pixel_bytes];
    }
  }
}

double whole_gain(double gain) {
  throw_if(!(std::abs(gain) <= std::numeric_limits<int>::max()),
           "`gain {}` is out of range; expected a 32-bit integer", gain);
  return std::round(gain);
}

/// Throws Error for settings that V4L2 does not have.
FrameFormat format_from(const CameraSettings& settings) {
  const PixelFormat pixels = settings.pixel_format;
  throw_if(pixels != PixelFormat::mono8 && pixels != PixelFormat::mono10 &&
               pixels != PixelFormat::mono12 && pixels != PixelFormat::rgb8 &&
               pixels != PixelFormat::mjpg,
           "`pixel_format {}`: not available on v4l2 cameras; use Mono8, Mono10, Mono12, RGB8 or "
           "MJPG, or BayerRG8 and so on",
           pixel_format_of(settings));

  const Rectangle region = settings.region.value_or(Rectangle{.size = {640, 480}});
  throw_if(region.x != 0 || region.y != 0,
           "`region {}x{}+{}+{}`: v4l2 cameras have a size but no region offset; give e.g. 640x480",
           region.size.width, region.size.height, region.x, region.y);

  throw_if(!settings.trigger.empty() || !settings.strobe.empty(),
           "{} {}: v4l2 cameras have no trigger",
           settings.strobe.empty() ? "`trigger`" : "`strobe`",
           settings.strobe.empty() ? settings.trigger : settings.strobe);
  throw_if(!settings.nodes.empty(), "`feature`: v4l2 cameras have no GenICam nodes");

  if (settings.gain) (void)whole_gain(*settings.gain);
  return {{values_of(pixels) * region.size.width, region.size.height}, bits_of(pixels)};
}

/// An open camera with its buffers.
class V4l2Stream {
 public:
  V4l2Stream(std::string name, std::unique_ptr<VideoDevice> device, const FrameFormat& format,
             const CameraSettings& settings)
      : name_(std::move(name)), device_(std::move(device)) {
    throw_if(!camera_of(*device_), "{} is not a streaming camera", name_);

    set_format(format, settings);
    if (settings.frame_rate) set_rate(*settings.frame_rate);
    if (settings.exposure) set_control(CameraControl::exposure, *settings.exposure * 1e3);
    if (settings.gain) set_control(CameraControl::gain, *settings.gain);
  }

  ~V4l2Stream() { stop(); }

  /// After an exception it can be started again.
  void start() try {
    // 1. Request buffers from the driver.
    auto request = cleared<v4l2_requestbuffers>();
    request.count = v4l2_buffer_count;
    request.memory = V4L2_MEMORY_MMAP;
    require(VIDIOC_REQBUFS, &request, "buffers");

    // 2. Map each and hand it over to be filled.
    for (std::uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer = empty_buffer(i);
      require(VIDIOC_QUERYBUF, &buffer, "buffers");
      void* memory = device_->map(buffer.length, buffer.m.offset);
      if (memory == nullptr) fail("buffers");
      buffers_.push_back({static_cast<std::uint8_t*>(memory), buffer.length});
      require(VIDIOC_QBUF, &buffer, "buffers");
    }

    // 3. Start the stream.
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    require(VIDIOC_STREAMON, &type, "a stream");
  } catch (const std::exception&) {
    release();
    throw;
  }

  void stop() {
    if (!buffers_.empty()) release();
  }

  /// Null if V4L2 has no such control.
  [[nodiscard]] std::optional<ControlValue> control(CameraControl which) const {
    if (which == CameraControl::frame_rate) return std::nullopt;
    const auto& [id, _, manual, unit] =
        which == CameraControl::exposure ? exposure_control : gain_control;

    v4l2_queryctrl range{};
    range.id = id;
    v4l2_control now{id, 0};
    if (device_->control(VIDIOC_QUERYCTRL, &range) != 0 ||
        (range.flags & V4L2_CTRL_FLAG_DISABLED) != 0 ||
        device_->control(VIDIOC_G_CTRL, &now) != 0) {
      return std::nullopt;
    }

    return ControlValue{unit * now.value, unit * range.minimum, unit * range.maximum};
  }

  void set_control(CameraControl which, double value) const {
    if (which == CameraControl::frame_rate) return;

    const bool is_exposure = which == CameraControl::exposure;
    const auto& [id, automatic, manual, unit] = is_exposure ? exposure_control : gain_control;
    const double steps = is_exposure ? std::round(value / unit) : whole_gain(value);
    // Automatic mode off first: it would overwrite the value. Not every camera has one.
    put_control(*device_, automatic, manual);
    throw_if((is_exposure && !(steps >= 1 && steps <= std::numeric_limits<int>::max())) ||
                 !put_control(*device_, id, static_cast<int>(steps)),
             "camera {} refused {}", name_,
             is_exposure ? fmt::format("an exposure of {} s", value / 1e3)
                         : fmt::format("a gain of {}", steps));
  }

  /// nullopt if the camera is gone.
  std::optional<Arrival> fetch(Frame& frame, milliseconds timeout) {
    if (!device_->wait(timeout)) return Arrival::nothing;

    v4l2_buffer buffer = empty_buffer(0);
    if (device_->control(VIDIOC_DQBUF, &buffer) != 0) {
      if (errno == EAGAIN) return Arrival::nothing;
      return std::nullopt;
    }

    const Arrival arrival = take(buffer, frame);
    if (device_->control(VIDIOC_QBUF, &buffer) != 0) return std::nullopt;
    return arrival;
  }

 private:
  /// Ends the stream and frees its buffers.
  void release() {
    // Buffers must be unmapped before the driver frees them, which a request for 0 buffers does.
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    device_->control(VIDIOC_STREAMOFF, &type);
    for (const std::span<std::uint8_t> buffer : buffers_) {
      device_->unmap(buffer.data(), buffer.size());
    }
    buffers_.clear();
    auto request = cleared<v4l2_requestbuffers>();
    request.memory = V4L2_MEMORY_MMAP;
    device_->control(VIDIOC_REQBUFS, &request);
  }

  static v4l2_buffer empty_buffer(std::uint32_t index) {
    auto buffer = cleared<v4l2_buffer>();
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    return buffer;
  }

  [[noreturn]] void fail(std::string_view what) const {
    throw WorldError(fmt::format("camera {} gives no {}: {}", name_, what, std::strerror(errno)));
  }

  void require(unsigned long request, void* argument, std::string_view what) const {
    if (device_->control(request, argument) != 0) fail(what);
  }

  void set_format(const FrameFormat& frames, const CameraSettings& settings) {
    keeps_mosaic_ = settings.keep_mosaic;

    // 1. The pixels per row: colour frames hold three values per pixel side by side.
    const PixelFormat pixels = settings.pixel_format;
    const int values = values_of(pixels);
    const bool compressed = pixels == PixelFormat::mjpg;
    const FrameFormat wanted{{frames.size.width / values, frames.size.height}, frames.bits};

    // 2. Try the layouts with these bits in order of preference, until the driver takes one.
    for (const PixelLayout& layout : layouts) {
      if (layout.bits != wanted.bits || layout.values != values ||
          layout.mosaic != settings.mosaic || (layout.code == V4L2_PIX_FMT_MJPEG) != compressed) {
        continue;
      }

      auto format = cleared<v4l2_format>();
      format.fmt.pix.width = static_cast<std::uint32_t>(wanted.size.width);
      format.fmt.pix.height = static_cast<std::uint32_t>(wanted.size.height);
      format.fmt.pix.pixelformat = layout.code;
      format.fmt.pix.field = V4L2_FIELD_NONE;
      if (device_->control(VIDIOC_S_FMT, &format) != 0) {
        if (errno == EINVAL) continue;
        fail("frames");
      }
      if (format.fmt.pix.pixelformat != layout.code) continue;  // the driver chose another format

      const Size size{static_cast<int>(format.fmt.pix.width),
                      static_cast<int>(format.fmt.pix.height)};
      throw_if(size != wanted.size, "camera {} has no frame size {}; the nearest is {}", name_,
               text_of(wanted.size), text_of(size));

      // 3. Rows may be padded, but cannot be shorter than their pixels.
      layout_ = layout;
      const auto tight = static_cast<std::size_t>(frames.size.width * layout.bytes);
      row_bytes_ = std::max<std::size_t>(format.fmt.pix.bytesperline, tight);
      return;
    }

    throw Error(fmt::format("camera {} has no {} frames with {} bits ({})", name_,
                            values == 1 ? "grey" : "colour", wanted.bits,
                            compressed                 ? "MJPG"
                            : !settings.mosaic.empty() ? pixel_format_of(settings)
                            : values == 1              ? "GREY, YUYV, Y10 or Y12; many have MJPG"
                                                       : "RGB24"));
  }

  void set_rate(double rate) const {
    constexpr std::uint32_t precision = 1000;  // of a Hz
    throw_if(!(rate * precision >= 1 && rate <= 1e6),
             "camera {}: rate {} Hz is out of range; 0.001 to 1000000 Hz", name_, rate);

    auto parameters = cleared<v4l2_streamparm>();
    parameters.parm.capture.timeperframe = {
        precision, static_cast<std::uint32_t>(std::lround(rate * precision))};

    if (device_->control(VIDIOC_S_PARM, &parameters) != 0) {
      throw Error(
          fmt::format("camera {} refused a rate of {} Hz: {}", name_, rate, std::strerror(errno)));
    }
  }

  Arrival take(const v4l2_buffer& buffer, Frame& frame) const {
    if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0 || buffer.index >= buffers_.size()) {
      return Arrival::damaged;
    }

    const std::span<const std::uint8_t> bytes = buffers_[buffer.index];
    const auto pixel_bytes = static_cast<std::size_t>(layout_.bytes);
    const Size size = frame.format().size;

    // The last row may lack its padding.
    const std::size_t needed = row_bytes_ * static_cast<std::size_t>(size.height - 1) +
                               pixel_bytes * static_cast<std::size_t>(size.width);

    if (layout_.code == V4L2_PIX_FMT_MJPEG) {
#ifdef SLIPSTREAM_IO
      const auto jpeg = bytes.first(std::min<std::size_t>(buffer.bytesused, bytes.size()));
      if (!decode_jpeg(jpeg, std::get<Image<std::uint8_t>>(frame.pixels))) return Arrival::damaged;
#else
      throw Error("`pixel_format MJPG`: this build reads no pictures (-DSLIPSTREAM_IO=ON)");
#endif
    } else if (buffer.bytesused < needed || bytes.size() < needed) {
      return Arrival::damaged;
    } else {
      std::visit([&](auto& image) { copy_rows(bytes.data(), row_bytes_, pixel_bytes, image); },
                 frame.pixels);
      if (!layout_.mosaic.empty() && !keeps_mosaic_) make_grey(frame);
    }

    frame.stamp = {.sequence = buffer.sequence,
                   .pattern_index = std::nullopt,
                   .device_time = time_of(buffer.timestamp),
                   .host_time = steady_clock::now()};
    return Arrival::frame;
  }

  std::string name_;
  std::unique_ptr<VideoDevice> device_;
  PixelLayout layout_ = layouts[0];
  bool keeps_mosaic_ = false;
  std::size_t row_bytes_ = 0;
  std::vector<std::span<std::uint8_t>> buffers_;
};

class V4l2Source final : public CameraSource<V4l2Stream> {
 public:
  V4l2Source(const std::string& name, std::function<std::unique_ptr<VideoDevice>()> open,
             const CameraSettings& settings)
      : CameraSource(name, settings, nullptr, format_from(settings)), open_(std::move(open)) {
    require_valid(format_);
    connection_ = connect();
  }

  void start() override {
    const bool gone = !connection_;
    std::shared_ptr<V4l2Stream> stream = gone ? connect() : connection_;
    stream->start();  // if reopening throws, it is still gone
    count_.begin(0);
    if (gone) regain(std::move(stream));
  }

  void stop() override {
    if (connection_) connection_->stop();
  }

  Arrival next(Frame& frame, milliseconds timeout) override {
    if (!connection_) return seek(timeout);
    if (frame.format() != format()) frame = Frame(format());
    const std::optional<Arrival> arrival = connection_->fetch(frame, timeout);
    if (!arrival) lose();
    if (arrival == Arrival::frame) frame.stamp.sequence = count(frame.stamp.sequence);
    return arrival.value_or(Arrival::nothing);
  }

 private:
  [[nodiscard]] std::shared_ptr<V4l2Stream> connect() const {
    return std::make_shared<V4l2Stream>(name_, open_(), format_, settings_now());
  }

  Arrival seek(milliseconds timeout) try {
    start();
    return Arrival::nothing;
  } catch (const std::exception&) {
    std::this_thread::sleep_for(std::min(timeout, milliseconds(100)));
    return Arrival::nothing;
  }

  const std::function<std::unique_ptr<VideoDevice>()> open_;
};

}  // namespace

std::unique_ptr<FrameSource> open_v4l2_camera(
    const std::string& name, const std::function<std::unique_ptr<VideoDevice>()>& open,
    const CameraSettings& settings) {
  return std::make_unique<V4l2Source>(name, open, settings);
}

std::vector<CameraDescription> list_v4l2_cameras() {
  constexpr int most = 64;
  std::vector<CameraDescription> cameras;
  require_descriptors(1, "listing cameras");  // below, a device that cannot be opened is none

  for (int number = 0; number < most; ++number) {
    const std::string path = fmt::format("/dev/video{}", number);
    try {
      const auto capability = camera_of(*open_video_device(path));
      // Devices without pictures, e.g. a camera's metadata, are skipped.
      if (!capability) continue;
      cameras.push_back({.name = std::to_string(number),
                         .vendor = text_of(capability->driver),
                         .model = text_of(capability->card),
                         .serial = "",
                         .address = text_of(capability->bus_info),
                         .protocol = "V4L2"});
    } catch (const WorldError&) {  // no such device, or no permission
    }
  }

  return cameras;
}

}  // namespace slipstream
