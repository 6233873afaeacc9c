#include "slipstream/camera/virtual_gige_camera.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>

#include <arpa/inet.h>
#include <arv.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include "slipstream/camera/g_object.h"
#include "slipstream/error/error.h"

namespace slipstream {
namespace {

constexpr std::uint16_t control_port = 3956;  // of GigE Vision
constexpr const char* frames_sent_key = "slipstream-frames-sent";

/// All of 127.x.x.x may be bound on this machine, but a camera is found by an interface's own.
[[noreturn]] void throw_no_interface(const std::string& address) {
  const bool loopback = address.starts_with("127.");
  throw WorldError(
      fmt::format("cannot serve a camera at {}: no network interface has that address; give it to "
                  "one first, as with: sudo ip address add {} dev {}",
                  address, address + (loopback ? "/8" : "/24"), loopback ? "lo" : "INTERFACE"));
}

/// The fake camera says that it runs even where it could not listen.
void require_free_port(const std::string& address) {
  sockaddr_in wanted{};
  wanted.sin_family = AF_INET;
  wanted.sin_port = htons(control_port);
  if (::inet_pton(AF_INET, address.c_str(), &wanted.sin_addr) != 1) {
    throw Error(fmt::format("{} is no address as 127.0.0.1", address));
  }
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const int failed =
      descriptor < 0 ||
      ::bind(descriptor, reinterpret_cast<const sockaddr*>(&wanted), sizeof(wanted)) != 0;
  const int reason = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (failed != 0 && reason == EADDRNOTAVAIL) throw_no_interface(address);
  if (failed != 0) {
    throw WorldError(fmt::format("cannot serve a camera on UDP port {} of {}: {}", control_port,
                                 address, std::strerror(reason)));
  }
}

void require_valid(const std::vector<Reel>& reels, const std::string& serial) {
  for (const Reel& reel : reels) {
    if (reel.frames.empty()) throw Error("a virtual camera with no frames; at least one is wanted");
    for (const Frame& frame : reel.frames) {
      if (frame.format() != reels.front().frames.front().format() || frame.bits != 8) {
        throw Error("the virtual GigE camera gives frames of one size and 8 bits; others came");
      }
    }
  }
  if (serial.empty() || serial.size() > 15) {
    throw Error(fmt::format("a serial number of {} letters, '{}'; 1 to 15 are possible",
                            serial.size(), serial));
  }
}

/// Whether the client asked for no more than there is. It may write anything into the registers,
/// and the buffer is only then sure to be as large as they say.
bool is_within(int from, int length, int all) {
  return from >= 0 && from <= all && length >= 0 && length <= all;
}

/// The part of `picture` that the client asked for, whose numbers are within it; zeros beside the
/// picture.
void copy_region(const Image<std::uint8_t>& picture, int left, int top, Size size,
                 std::uint8_t* to) {
  const int width = std::clamp(picture.width() - left, 0, size.width);
  for (int row = 0; row < size.height; ++row, to += size.width) {
    const int copied = row < picture.height() - top ? width : 0;
    if (copied > 0) std::copy_n(picture.row(top + row) + left, copied, to);
    std::fill(to + copied, to + size.width, std::uint8_t{0});
  }
}

}  // namespace

struct VirtualGigeCamera::Served {
  std::vector<Reel> reels;
  std::size_t reel = 0;     ///< that the client sees
  bool seen_whole = false;  ///< by it, or one before
  std::atomic<std::uint64_t> sent = 0;
  GObjectPointer<ArvGvFakeCamera> camera;  ///< its thread reads the rest; goes first

  [[nodiscard]] ArvFakeCamera* fake() const {
    return arv_gv_fake_camera_get_fake_camera(camera.get());
  }
  [[nodiscard]] int read(std::uint32_t address) const {
    std::uint32_t value = 0;
    arv_fake_camera_read_register(fake(), address, &value);
    return static_cast<int>(value);
  }
  void write(std::uint32_t address, std::uint32_t value) const {
    arv_fake_camera_write_register(fake(), address, value);
  }

  /// What frame k since the client's start shows.
  const Image<std::uint8_t>& picture(std::size_t k) {
    if (k == 0 && seen_whole && reel + 1 < reels.size()) {
      ++reel;
      seen_whole = false;
    }
    const auto& [frames, order, enough] = reels[reel];
    seen_whole |= k + 1 == (enough > 0 ? enough : order.size());
    return std::get<Image<std::uint8_t>>(frames[order[k % order.size()]].pixels);
  }

  /// Numbers the frame, counted since its client started, and writes the pixels that belong to it.
  void fill(ArvBuffer* buffer) {
    // The buffer is made anew for each start of frames.
    GObject* counted = reinterpret_cast<GObject*>(buffer);
    const std::size_t k = GPOINTER_TO_SIZE(g_object_get_data(counted, frames_sent_key));
    g_object_set_data(counted, frames_sent_key, GSIZE_TO_POINTER(k + 1));
    constexpr std::size_t largest_number = 65535;
    arv_buffer_set_frame_id(buffer, 1 + k % largest_number);

    const Size size{arv_buffer_get_image_width(buffer), arv_buffer_get_image_height(buffer)};
    const Image<std::uint8_t>& shown = picture(k);
    std::size_t unset_size = 0;
    auto* pixels = const_cast<void*>(arv_buffer_get_data(buffer, &unset_size));
    const int left = read(ARV_FAKE_CAMERA_REGISTER_X_OFFSET);
    const int top = read(ARV_FAKE_CAMERA_REGISTER_Y_OFFSET);
    if (arv_buffer_get_image_pixel_format(buffer) == ARV_PIXEL_FORMAT_MONO_8 &&
        is_within(left, size.width, shown.width()) && is_within(top, size.height, shown.height())) {
      copy_region(shown, left, top, size, static_cast<std::uint8_t*>(pixels));
    }
    ++sent;
  }
};

VirtualGigeCamera::VirtualGigeCamera(std::vector<Frame> loop, const std::string& address,
                                     const std::string& serial)
    : VirtualGigeCamera(std::vector<Reel>{reel_of(std::move(loop))}, address, serial) {}

VirtualGigeCamera::VirtualGigeCamera(std::vector<Reel> reels, const std::string& address,
                                     const std::string& serial)
    : served_(std::make_unique<Served>()) {
  require_valid(reels, serial);
  require_free_port(address);
  const Size size = reels.front().frames.front().format().size;
  served_->reels = std::move(reels);
  served_->camera.reset(arv_gv_fake_camera_new(address.c_str(), serial.c_str()));
  if (!served_->camera || !arv_gv_fake_camera_is_running(served_->camera.get())) {
    throw_no_interface(address);
  }
  const auto width = static_cast<std::uint32_t>(size.width);
  const auto height = static_cast<std::uint32_t>(size.height);
  served_->write(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, width);
  served_->write(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, height);
  served_->write(ARV_FAKE_CAMERA_REGISTER_WIDTH, width);
  served_->write(ARV_FAKE_CAMERA_REGISTER_HEIGHT, height);
  const auto fill = [](ArvBuffer* buffer, void* served, guint32, guint32, ArvPixelFormat) {
    static_cast<Served*>(served)->fill(buffer);
  };
  arv_fake_camera_set_fill_pattern(served_->fake(), fill, served_.get());
}

VirtualGigeCamera::~VirtualGigeCamera() = default;

void VirtualGigeCamera::set_frame_rate(double rate) {
  if (!(rate >= 1e-3 && rate <= 1e6)) {  // the register holds the period, us, in 32 bits
    throw Error(fmt::format("a rate of {} Hz; 0.001 to a million", rate));
  }
  served_->write(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
                 static_cast<std::uint32_t>(1e6 / rate));
}

void VirtualGigeCamera::set_trigger_rate(double rate) {
  if (!(rate > 0)) throw Error(fmt::format("a trigger rate of {} Hz; it is above 0", rate));
  arv_fake_camera_set_trigger_frequency(served_->fake(), rate);
}

void VirtualGigeCamera::set_packet_loss(double share) {
  g_object_set(served_->camera.get(), "gvsp-lost-ratio", share, nullptr);
}

std::uint64_t VirtualGigeCamera::sent() const {
  return served_->sent;
}

}  // namespace slipstream
