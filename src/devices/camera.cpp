#include "slipstream/camera.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <memory>
#include <regex>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "devices/genicam.h"
#include "devices/v4l2.h"
#include "io/file.h"

namespace slipstream {

#ifndef SLIPSTREAM_CAMERAS  // stub for builds without Aravis
std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name, const CameraSettings&) {
  throw Error("camera aravis:" + name +
              " needs Aravis, but this program was built without it (libaravis-dev, "
              "-DSLIPSTREAM_CAMERAS=ON)");
}

std::vector<CameraDescription> list_genicam_cameras() {
  return {};
}
#endif

namespace {

static_assert(std::endian::native == std::endian::little,
              "two-byte pixels are read in this machine's byte order");

void copy_words(int /*bits*/, const std::uint8_t* bytes, std::span<std::uint16_t> pixels) {
  std::memcpy(pixels.data(), bytes, pixels.size_bytes());
}

/// Packed pixels of `bits` each, low bits first.
void unpack_bits(int bits, const std::uint8_t* bytes, std::span<std::uint16_t> pixels) {
  const std::uint32_t mask = (1U << bits) - 1;
  std::uint32_t held = 0;
  int held_bits = 0;

  for (std::uint16_t& pixel : pixels) {
    // Take in bytes above the bits held, until they make a pixel.
    for (; held_bits < bits; held_bits += 8) {
      held |= static_cast<std::uint32_t>(*bytes++) << held_bits;
    }

    pixel = static_cast<std::uint16_t>(held & mask);
    held >>= bits;
    held_bits -= bits;
  }
}

/// Two pixels in three bytes: high bits, the low bits of both (the first pixel's are lower), high
/// bits.
void unpack_pairs(int bits, const std::uint8_t* bytes, std::span<std::uint16_t> pixels) {
  const int low_bits = bits - 8;
  const int mask = (1 << low_bits) - 1;

  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::uint8_t* pair = bytes + i / 2 * 3;
    const int high = i % 2 == 0 ? pair[0] : pair[2];
    const int low = (i % 2 == 0 ? pair[1] : pair[1] >> 4) & mask;
    pixels[i] = static_cast<std::uint16_t>(high << low_bits | low);
  }
}

struct FormatDescription {
  PixelFormat format;
  std::string_view name;
  int bits;         ///< bytes from the camera
  int stored_bits;  ///< bits per value
  /// Unpacks into 16-bit pixels; null for 8-bit formats.
  void (*unpack)(int bits, const std::uint8_t* bytes, std::span<std::uint16_t> pixels) = nullptr;
};

constexpr std::array<FormatDescription, 10> formats{{
    {PixelFormat::mono8, "Mono8", 8, 8},
    {PixelFormat::mono10, "Mono10", 10, 16, copy_words},
    {PixelFormat::mono12, "Mono12", 12, 16, copy_words},
    {PixelFormat::mono16, "Mono16", 16, 16, copy_words},
    {PixelFormat::mono10p, "Mono10p", 10, 10, unpack_bits},
    {PixelFormat::mono12p, "Mono12p", 12, 12, unpack_bits},
    {PixelFormat::mono10_packed, "Mono10Packed", 10, 12, unpack_pairs},
    {PixelFormat::mono12_packed, "Mono12Packed", 12, 12, unpack_pairs},
    {PixelFormat::rgb8, "RGB8", 8, 8},
    {PixelFormat::mjpg, "MJPG", 8, 8},
}};

const FormatDescription& describe(PixelFormat format) {
  return *std::ranges::find(formats, format, &FormatDescription::format);
}

}  // namespace

std::string_view name_of(PixelFormat format) {
  return describe(format).name;
}

std::vector<std::string_view> pixel_format_names() {
  std::vector<std::string_view> names;
  for (const FormatDescription& format : formats) names.push_back(format.name);
  return names;
}

PixelFormat pixel_format_named(std::string_view name) {
  const auto* const found = std::ranges::find(formats, name, &FormatDescription::name);
  if (found != formats.end()) return found->format;
  throw Error(
      fmt::format("pixel format '{}' is unknown; expected one of: {}, or BayerRG8 and so on", name,
                  fmt::join(pixel_format_names(), ", ")));
}

int bits_of(PixelFormat format) {
  return describe(format).bits;
}

int values_of(PixelFormat format) {
  return format == PixelFormat::rgb8 ? 3 : 1;
}

std::size_t bytes_of(PixelFormat format, std::size_t values) {
  if (describe(format).unpack == unpack_pairs) return (values + 1) / 2 * 3;
  return (values * static_cast<std::size_t>(describe(format).stored_bits) + 7) / 8;
}

bool unpack(PixelFormat format, std::span<const std::uint8_t> bytes, Frame& frame) {
  if (auto* image = std::get_if<Image<std::uint8_t>>(&frame.pixels)) {
    // 8-bit pixels are copied as they are.
    if (bytes.size() < image->pixel_count()) return false;
    std::copy_n(bytes.begin(), image->pixel_count(), image->begin());
    return true;
  }

  auto& image = std::get<Image<std::uint16_t>>(frame.pixels);
  if (bytes.size() < bytes_of(format, image.pixel_count())) return false;
  describe(format).unpack(bits_of(format), bytes.data(), {image.begin(), image.pixel_count()});
  return true;
}

std::string pixel_format_of(const CameraSettings& settings) {
  const std::string name(name_of(settings.pixel_format));
  return settings.mosaic.empty() ? name : "Bayer" + settings.mosaic + name.substr(4);
}

void set_pixel_format(CameraSettings& settings, const std::string& name) {
  std::smatch mosaic;
  const bool is_mosaic = std::regex_match(name, mosaic, std::regex("Bayer(RG|GR|GB|BG)(1.*|8)"));
  settings.pixel_format = pixel_format_named(is_mosaic ? "Mono" + mosaic[2].str() : name);
  settings.mosaic = mosaic[1].str();
}

std::unique_ptr<FrameSource> open_camera(const std::string& name, const CameraSettings& settings) {
  const std::string scheme = name.substr(0, name.find(':'));
  const std::string what = name.substr(std::min(scheme.size() + 1, name.size()));
  if (scheme == "aravis") return open_genicam_camera(what, settings);
  throw_if(scheme != "v4l2", "camera '{}' is unknown; one of aravis:NAME, v4l2:NUMBER", name);

  const auto number = number_in<int>(what);
  throw_if(!number || *number < 0, "source v4l2:{}: expected a number, e.g. v4l2:0 for /dev/video0",
           what);

  const std::string path = fmt::format("/dev/video{}", *number);
  return open_v4l2_camera(
      path, [path] { return open_video_device(path); }, settings);
}

std::vector<CameraDescription> list_cameras() {
  std::vector<CameraDescription> cameras;
  // Names that open_camera() takes begin with the scheme.
  for (const auto& [scheme, list] :
       {std::pair{"aravis:", &list_genicam_cameras}, std::pair{"v4l2:", &list_v4l2_cameras}}) {
    for (CameraDescription& camera : list()) {
      camera.name.insert(0, scheme);
      cameras.push_back(std::move(camera));
    }
  }

  return cameras;
}

}  // namespace slipstream
