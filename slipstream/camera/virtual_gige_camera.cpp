#include "slipstream/camera/virtual_gige_camera.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <mutex>
#include <random>
#include <thread>

#include <arpa/inet.h>
#include <arv.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <poll.h>

#include "slipstream/camera/detail/gige_control.h"
#include "slipstream/camera/detail/gige_packets.h"
#include "slipstream/camera/detail/udp_socket.h"
#include "slipstream/camera/g_object.h"
#include "slipstream/error/error.h"

namespace slipstream {
namespace {

using std::chrono::steady_clock;

constexpr std::uint16_t control_port = 3956;  // of GigE Vision

/// All of 127.x.x.x may be bound on this machine, but a camera is found by an interface's own.
[[noreturn]] void throw_no_interface(const std::string& address) {
  const bool loopback = address.starts_with("127.");
  throw WorldError(
      fmt::format("cannot serve a camera at {}: no network interface has that address; give it to "
                  "one first, as with: sudo ip address add {} dev {}",
                  address, address + (loopback ? "/8" : "/24"), loopback ? "lo" : "INTERFACE"));
}

std::uint32_t host_from(const std::string& address) {
  in_addr host{};
  if (::inet_pton(AF_INET, address.c_str(), &host) != 1) {
    throw Error(fmt::format("{} is no address as 127.0.0.1", address));
  }
  return ntohl(host.s_addr);
}

/// Where what is meant for all goes on the network of the interface that has that address.
std::uint32_t broadcast_of(const std::string& address) {
  const auto host_of = [](const sockaddr* end) {
    return ntohl(reinterpret_cast<const sockaddr_in*>(end)->sin_addr.s_addr);
  };
  const std::uint32_t host = host_from(address);
  ifaddrs* first = nullptr;
  ::getifaddrs(&first);
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> all(first, &::freeifaddrs);
  for (const ifaddrs* each = first; each != nullptr; each = each->ifa_next) {
    const bool has_address = each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET;
    if (!has_address || host_of(each->ifa_addr) != host) continue;
    const std::uint32_t broadcast = host | ~host_of(each->ifa_netmask);
    return broadcast == host ? INADDR_BROADCAST : broadcast;
  }
  throw_no_interface(address);
}

/// The registers of Aravis' fake camera and its description, as its own server shows them.
std::vector<std::uint8_t> fake_camera_memory(const std::string& serial) {
  const GObjectPointer<ArvFakeCamera> camera(arv_fake_camera_new(serial.c_str()));
  constexpr std::uint32_t last = 4;  // it refuses to be read up to its end
  std::vector<std::uint8_t> memory(ARV_FAKE_CAMERA_MEMORY_SIZE);
  arv_fake_camera_read_memory(camera.get(), 0, ARV_FAKE_CAMERA_MEMORY_SIZE - last, memory.data());
  std::size_t size = 0;
  const char* description = arv_fake_camera_get_genicam_xml(camera.get(), &size);
  memory.insert(memory.end(), description, description + size);
  memory.resize((memory.size() + 3) / 4 * 4);  // clients read four bytes at a time
  return memory;
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

}  // namespace

struct VirtualGigeCamera::Served {
  std::vector<Reel> reels;
  const UdpSocket subnet_discovery, global_discovery, control_socket, stream_socket;
  GigeControl control;
  std::size_t reel = 0;     ///< that the client sees
  bool seen_whole = false;  ///< by it, or one before
  std::mutex mutex;         ///< of control
  std::atomic<std::chrono::microseconds> trigger_period{std::chrono::milliseconds(40)};
  std::atomic<double> packet_loss = 0;
  std::atomic<std::uint64_t> sent = 0;
  std::minstd_rand random;
  std::jthread thread;  ///< uses the rest; goes first

  Served(std::vector<Reel> frames, const std::string& address, const std::string& serial)
      : reels(std::move(frames)),
        subnet_discovery({broadcast_of(address), control_port}, true),
        global_discovery({INADDR_BROADCAST, control_port}, true),
        control_socket({host_from(address), control_port}, false),
        stream_socket({host_from(address), 0}, false),
        control(fake_camera_memory(serial)) {}

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

  /// Frame k since the client's start, and its number, counted from 1.
  void send(const GigeStream& stream, std::size_t k) {
    constexpr std::size_t largest_number = 65535;
    const auto number = static_cast<std::uint16_t>(1 + k % largest_number);
    for_each_packet(picture(k), stream.region, stream.packet_bytes, number,
                    steady_clock::now().time_since_epoch(), [&](auto packet) {
                      const bool lost = std::uniform_real_distribution()(random) < packet_loss;
                      if (!lost) stream_socket.send(packet, stream.to);
                    });
    ++sent;
  }

  /// At most one packet of each socket, so that a flood of them keeps no frame waiting. Waits less
  /// than a second for the first.
  void answer_packets(steady_clock::duration longest_wait) {
    const std::array sockets{&control_socket, &global_discovery, &subnet_discovery};
    std::array<pollfd, 3> waiting{};
    for (std::size_t i = 0; i < sockets.size(); ++i) {
      waiting[i] = {.fd = sockets[i]->descriptor(), .events = POLLIN, .revents = 0};
    }
    const timespec wait{.tv_sec = 0, .tv_nsec = std::max(0L, longest_wait.count())};
    if (::ppoll(waiting.data(), waiting.size(), &wait, nullptr) <= 0) return;
    for (const UdpSocket* socket : sockets) {
      std::array<std::uint8_t, 1024> room;  // longer than any packet of the protocol
      UdpAddress from;
      const auto packet = socket->receive(room, from);
      const std::lock_guard lock(mutex);
      const auto answer = control.answer(packet, from, steady_clock::now());
      if (!answer.empty()) control_socket.send(answer, from);
    }
  }

  void run(const std::stop_token& stop) {
    constexpr std::chrono::milliseconds idle(50);
    steady_clock::time_point due = steady_clock::now();
    for (std::size_t k = 0; !stop.stop_requested();) {
      std::unique_lock lock(mutex);
      const auto stream = control.stream(steady_clock::now());
      const bool is_due = stream && stream->ready && steady_clock::now() >= due;
      if (is_due) control.write(GigeRegister::software_trigger, 0);
      lock.unlock();
      if (!stream) k = 0;  // who starts sees the first
      if (is_due) {
        send(*stream, k++);
        const std::chrono::microseconds period =
            stream->is_free ? stream->period : trigger_period.load();
        due = std::max(due + period, steady_clock::now());
      }
      const bool is_ready = stream && stream->ready;
      answer_packets(is_ready ? std::min<steady_clock::duration>(due - steady_clock::now(), idle)
                              : idle);
    }
  }
};

VirtualGigeCamera::VirtualGigeCamera(std::vector<Frame> loop, const std::string& address,
                                     const std::string& serial)
    : VirtualGigeCamera(std::vector<Reel>{reel_of(std::move(loop))}, address, serial) {}

VirtualGigeCamera::VirtualGigeCamera(std::vector<Reel> reels, const std::string& address,
                                     const std::string& serial) {
  require_valid(reels, serial);
  const Size size = reels.front().frames.front().format().size;
  served_ = std::make_unique<Served>(std::move(reels), address, serial);
  const auto width = static_cast<std::uint32_t>(size.width);
  const auto height = static_cast<std::uint32_t>(size.height);
  GigeControl& control = served_->control;
  control.set_up(GigeRegister::host, host_from(address));
  control.set_up(GigeRegister::sensor_width, width);
  control.set_up(GigeRegister::sensor_height, height);
  control.set_up(GigeRegister::width, width);
  control.set_up(GigeRegister::height, height);
  served_->thread = std::jthread([this](const std::stop_token& stop) { served_->run(stop); });
}

VirtualGigeCamera::~VirtualGigeCamera() = default;

void VirtualGigeCamera::set_frame_rate(double rate) {
  if (!(rate >= 1e-3 && rate <= 1e6)) {  // the register holds the period, us, in 32 bits
    throw Error(fmt::format("a rate of {} Hz; 0.001 to a million", rate));
  }
  const std::lock_guard lock(served_->mutex);
  served_->control.set_up(GigeRegister::frame_period, static_cast<std::uint32_t>(1e6 / rate));
}

void VirtualGigeCamera::set_trigger_rate(double rate) {
  if (!(rate > 0)) throw Error(fmt::format("a trigger rate of {} Hz; it is above 0", rate));
  served_->trigger_period = std::chrono::microseconds(static_cast<std::int64_t>(1e6 / rate));
}

void VirtualGigeCamera::set_packet_loss(double share) {
  served_->packet_loss = share;
}

std::uint64_t VirtualGigeCamera::sent() const {
  return served_->sent;
}

}  // namespace slipstream
