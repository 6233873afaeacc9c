#include "slipstream/devices/virtual_gige_camera.h"

#include <algorithm>

#include "slipstream/base/throw_if-inl.h"
#include "slipstream/devices/aravis_connection-inl.h"

namespace slipstream {
namespace {

using std::chrono::steady_clock;

/// Registers and description of Aravis' fake camera, read from its own server.
std::vector<std::uint8_t> fake_camera_memory(const std::string& serial, in_addr host, Size sensor) {
  const GObjectPointer<ArvFakeCamera> camera(arv_fake_camera_new(serial.c_str()));
  const GObjectPointer<GInetAddress> address(
      g_inet_address_new_from_bytes(reinterpret_cast<const guint8*>(&host), G_SOCKET_FAMILY_IPV4));
  arv_fake_camera_set_inet_address(camera.get(), address.get());
  const auto [width, height] = sensor;
  for (const auto& [at, pixels] : {std::pair{ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, width},
                                   std::pair{ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, height},
                                   std::pair{ARV_FAKE_CAMERA_REGISTER_WIDTH, width},
                                   std::pair{ARV_FAKE_CAMERA_REGISTER_HEIGHT, height}}) {
    arv_fake_camera_write_register(camera.get(), static_cast<guint32>(at),
                                   static_cast<guint32>(pixels));
  }
  constexpr std::uint32_t last = 4;  // it refuses reads that reach its end
  std::vector<std::uint8_t> memory(ARV_FAKE_CAMERA_MEMORY_SIZE);
  arv_fake_camera_read_memory(camera.get(), 0, ARV_FAKE_CAMERA_MEMORY_SIZE - last, memory.data());
  std::size_t size = 0;
  const char* description = arv_fake_camera_get_genicam_xml(camera.get(), &size);
  memory.insert(memory.end(), description, description + size);
  memory.resize((memory.size() + 3) / 4 * 4);  // clients read four bytes at a time
  return memory;
}

std::vector<Reel> valid(std::vector<Reel> reels, const std::string& serial) {
  for (const Reel& reel : reels) {
    if (reel.frames.empty()) throw Error("a virtual camera needs at least one frame");
    for (const Frame& frame : reel.frames) {
      throw_if(frame.format() != reels.front().frames.front().format() || frame.bits != 8,
               "the virtual GigE camera needs 8-bit frames of one size");
    }
  }
  throw_if(serial.empty() || serial.size() > 15,
           "serial number of {} letters, '{}'; expected 1 to 15", serial.size(), serial);
  return reels;
}

}  // namespace

VirtualGigeCamera::VirtualGigeCamera(std::vector<Reel> reels, const std::string& address,
                                     const std::string& serial)
    : reels_(valid(std::move(reels), serial)),
      control_sockets_(address),
      stream_socket_(host_from(address), 0, false),
      control_(fake_camera_memory(serial, host_from(address),
                                  reels_.front().frames.front().format().size)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

/// The frame shown as frame k since the client's start.
const Image<std::uint8_t>& VirtualGigeCamera::picture(std::size_t k) {
  if (k == 0 && seen_whole_ && reel_ + 1 < reels_.size()) {
    ++reel_;
    seen_whole_ = false;
  }
  const auto& [frames, order, enough] = reels_[reel_];
  seen_whole_ |= k + 1 == (enough > 0 ? enough : order.size());
  return std::get<Image<std::uint8_t>>(frames[order[k % order.size()]].pixels);
}

/// Sends frame k since the client's start, numbered from 1. Clients enlarge their buffers at the
/// first packet, so the rest of the first frame waits for that.
void VirtualGigeCamera::send(const GigeStream& stream, std::size_t k) {
  constexpr std::size_t largest_number = 65535;
  const auto number = static_cast<std::uint16_t>(1 + k % largest_number);
  const GigeBlock block = block_of(picture(k), stream, number);
  for_each_packet(block, [&, is_first = k == 0](auto packet) mutable {
    const bool lost = std::uniform_real_distribution()(random_) < packet_loss_;
    if (!lost) stream_socket_.send(packet, stream.to);
    if (std::exchange(is_first, false)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  });
  ++sent_;
}

void VirtualGigeCamera::run(const std::stop_token& stop) {
  constexpr std::chrono::nanoseconds idle = std::chrono::milliseconds(50);
  constexpr std::chrono::microseconds trigger_period{40'000};  // limit for software triggers
  steady_clock::time_point due = steady_clock::now();
  for (std::size_t k = 0; !stop.stop_requested();) {
    std::unique_lock lock(mutex_);
    const auto stream = control_.stream(steady_clock::now());
    const bool is_ready = stream && (stream->is_free || stream->is_triggered);
    const bool is_due = is_ready && steady_clock::now() >= due;
    if (is_due) control_.write(GigeRegister::software_trigger, 0);
    lock.unlock();
    if (!stream) k = 0;  // a new client sees the first frame
    if (is_due) {
      send(*stream, k++);
      due =
          std::max(due + (stream->is_free ? stream->period : trigger_period), steady_clock::now());
    }
    control_sockets_.answer(is_ready ? std::min(due - steady_clock::now(), idle) : idle,
                            [this](auto packet, const sockaddr_in& from) {
                              const std::lock_guard answering(mutex_);
                              return control_.answer(packet, from, steady_clock::now());
                            });
  }
}

void VirtualGigeCamera::set_frame_rate(double rate) {
  if (!(rate >= 1e-3 && rate <= 1e6)) {  // the register holds the period in us, 32 bits
    throw Error(fmt::format("rate {} Hz is out of range; expected 0.001 to 1e6", rate));
  }
  const std::lock_guard lock(mutex_);
  control_.write(GigeRegister::frame_period, static_cast<std::uint32_t>(1e6 / rate));
}

}  // namespace slipstream
