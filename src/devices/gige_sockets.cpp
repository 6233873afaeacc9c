#include "devices/gige_sockets.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <linux/filter.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/numbers.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

constexpr std::uint16_t control_port = 3956;  // the GigE Vision control port

/// Broadcast address of the interface with this address.
in_addr broadcast_of(const std::string& address) {
  const in_addr host = host_from(address);
  const auto host_of = [](const sockaddr* end) {
    return reinterpret_cast<const sockaddr_in*>(end)->sin_addr.s_addr;
  };

  // All interfaces of this machine.
  ifaddrs* first = nullptr;
  ::getifaddrs(&first);
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> all(first, &::freeifaddrs);

  for (const ifaddrs* each = first; each != nullptr; each = each->ifa_next) {
    const bool has_address = each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET;
    if (!has_address || host_of(each->ifa_addr) != host.s_addr) continue;

    // Its broadcast address has all host bits set; without host bits, use the general one.
    const in_addr broadcast{host.s_addr | ~host_of(each->ifa_netmask)};
    return broadcast.s_addr == host.s_addr ? in_addr{INADDR_BROADCAST} : broadcast;
  }

  // All of 127.x.x.x can be bound, but clients find a camera only by an interface's own address.
  const bool loopback = address.starts_with("127.");
  throw WorldError(
      fmt::format("cannot serve a camera at {}: no network interface has that address; add it "
                  "first, e.g. with: sudo ip address add {} dev {}",
                  address, address + (loopback ? "/8" : "/24"), loopback ? "lo" : "INTERFACE"));
}

// Instructions of the kernel's packet filter. A load past the packet's end drops the packet.
constexpr unsigned short load_word = BPF_LD | BPF_W | BPF_ABS, load_byte = BPF_LD | BPF_B | BPF_ABS;
constexpr unsigned short load_length = BPF_LD | BPF_W | BPF_LEN, set_offset = BPF_LDX | BPF_IMM;
constexpr unsigned short load_half_there = BPF_LD | BPF_H | BPF_IND;
constexpr unsigned short load_byte_there = BPF_LD | BPF_B | BPF_IND;
constexpr unsigned short keep = BPF_ST, load_kept = BPF_LD | BPF_MEM, give = BPF_RET | BPF_K;
constexpr unsigned short mask = BPF_ALU | BPF_AND | BPF_K, add = BPF_ALU | BPF_ADD | BPF_K;
constexpr unsigned short negate = BPF_ALU | BPF_NEG, go_on = BPF_JMP | BPF_JA;
constexpr unsigned short if_equal = BPF_JMP | BPF_JEQ | BPF_K, if_set = BPF_JMP | BPF_JSET | BPF_K;
constexpr unsigned short if_beyond_offset = BPF_JMP | BPF_JGT | BPF_X;

/// The program for the kernel, see pass_pictures_only.
std::array<sock_filter, 31> picture_filter(const PictureStream& stream) {
  // Offsets count from the UDP header; SKF_NET_OFF reaches the IPv4 header before it, with the
  // sender's address at byte 12.
  constexpr auto sender = static_cast<std::uint32_t>(SKF_NET_OFF) + 12;
  constexpr std::uint32_t udp = 8, kind = udp + 4, long_numbers = 0x80, kinds = 0x7f;
  constexpr std::uint32_t leader = 1, trailer = 2, pixels = 3, picture = 1, leader_bytes = 36;
  constexpr std::uint32_t negative = 0x80000000;

  // The trailer follows all picture packets, which are numbered from 1.
  const auto trailer_number = [&](std::uint32_t header) {
    const std::uint32_t each = stream.packet_size - 20 - udp - header;  // 20: IPv4 header
    return (stream.picture_bytes + each - 1) / each + 1;
  };

  // The last field is an offset, a mask, a value to compare with, or the result. Jumps count
  // instructions skipped if true and if false.
  return {{// Drop packets from other senders.
           {load_word, 0, 0, sender},
           {if_equal, 0, 28, stream.camera},
           // 16-bit numbers: A = the trailer's number - this packet's.
           {set_offset, 0, 0, udp + 8},
           {load_byte, 0, 0, kind},
           {if_set, 5, 0, long_numbers},
           {load_word, 0, 0, kind},
           {mask, 0, 0, 0x00ffffff},
           {negate, 0, 0, 0},
           {add, 0, 0, trailer_number(8)},
           {go_on, 0, 0, 5},
           // Extended numbers: the same.
           {set_offset, 0, 0, udp + 20},
           {load_word, 0, 0, udp + 16},
           {if_set, 17, 0, negative},
           {negate, 0, 0, 0},
           {add, 0, 0, trailer_number(20)},
           // Drop packets after the trailer, and those without content.
           {if_set, 14, 0, negative},
           {keep, 0, 0, 0},
           {load_length, 0, 0, 0},
           {if_beyond_offset, 0, 11, 0},
           // Pass a trailer, and pixels before the trailer's number.
           {load_byte, 0, 0, kind},
           {mask, 0, 0, kinds},
           {if_equal, 7, 0, trailer},
           {if_equal, 0, 2, pixels},
           {load_kept, 0, 0, 0},
           {if_equal, 5, 4, 0},
           // Pass a whole leader of a picture.
           {if_equal, 0, 4, leader},
           {load_byte_there, 0, 0, leader_bytes - 1},
           {load_half_there, 0, 0, 2},
           {if_equal, 0, 1, picture},
           // Pass; drop.
           {give, 0, 0, 0xffffffff},
           {give, 0, 0, 0}}};
}

}  // namespace

in_addr host_from(const std::string& address) {
  in_addr host{};
  if (::inet_pton(AF_INET, address.c_str(), &host) == 1) return host;
  throw Error(fmt::format("{} is not an IPv4 address, e.g. 127.0.0.1", address));
}

UdpSocket::UdpSocket(in_addr host, std::uint16_t port, bool shared)
    : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  if (descriptor_ < 0) {
    throw WorldError(fmt::format("cannot open a UDP socket: {}", std::strerror(errno)));
  }

  const int share = shared ? 1 : 0;
  ::setsockopt(descriptor_, SOL_SOCKET, SO_REUSEADDR, &share, sizeof(share));

  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  at.sin_addr = host;
  if (::bind(descriptor_, reinterpret_cast<const sockaddr*>(&at), sizeof(at)) == 0) return;

  const std::string reason = std::strerror(errno);
  ::close(descriptor_);
  throw WorldError(
      fmt::format("cannot listen on UDP port {} of {}: {}", port, ::inet_ntoa(host), reason));
}

UdpSocket::~UdpSocket() {
  ::close(descriptor_);
}

std::uint16_t UdpSocket::port() const {
  sockaddr_in at{};
  socklen_t size = sizeof(at);
  ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&at), &size);
  return ntohs(at.sin_port);
}

std::vector<std::uint8_t> UdpSocket::receive(sockaddr_in& from) const {
  std::vector<std::uint8_t> packet(1024);
  socklen_t size = sizeof(from);
  const ssize_t length =
      ::recvfrom(descriptor_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_TRUNC,
                 reinterpret_cast<sockaddr*>(&from), &size);

  // MSG_TRUNC returns the full length, so that a packet cut to the buffer is noticed.
  const bool fits = length >= 0 && static_cast<std::size_t>(length) <= packet.size();
  packet.resize(fits ? static_cast<std::size_t>(length) : 0);
  return packet;
}

void UdpSocket::send(std::span<const std::uint8_t> packet, const sockaddr_in& to) const {
  ::sendto(descriptor_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
           sizeof(to));
}

void UdpSocket::send_whole(std::span<const std::uint8_t> packet, const sockaddr_in& to) const {
  for (const int cut : {IP_PMTUDISC_DO, IP_PMTUDISC_WANT}) {
    // The ban on fragments holds for this packet only.
    ::setsockopt(descriptor_, IPPROTO_IP, IP_MTU_DISCOVER, &cut, sizeof(cut));
    if (cut == IP_PMTUDISC_DO) send(packet, to);
  }
}

GigeControlSockets::GigeControlSockets(const std::string& address)
    : GigeControlSockets(host_from(address), broadcast_of(address)) {}

GigeControlSockets::GigeControlSockets(in_addr host, in_addr broadcast)
    : sockets_{UdpSocket(host, control_port, false),
               UdpSocket(in_addr{INADDR_BROADCAST}, control_port, true),
               UdpSocket(broadcast, control_port, true)} {}

void GigeControlSockets::answer(std::chrono::nanoseconds longest_wait, const Answer& answer) const {
  std::array<pollfd, 3> waiting{};
  std::transform(sockets_.begin(), sockets_.end(), waiting.begin(), [](const UdpSocket& socket) {
    return pollfd{.fd = socket.descriptor(), .events = POLLIN, .revents = 0};
  });

  const timespec wait{.tv_sec = 0, .tv_nsec = std::max(0L, longest_wait.count())};
  if (::ppoll(waiting.data(), waiting.size(), &wait, nullptr) <= 0) return;

  for (const UdpSocket& socket : sockets_) {
    sockaddr_in from{};
    const auto packet = socket.receive(from);
    // Only the camera's own address takes commands other than discovery.
    constexpr std::uint16_t discovery = 0x02;
    const bool is_discovery =
        packet.size() >= 4 && number_at<std::uint16_t, std::endian::big>(packet, 2) == discovery;

    if (&socket != &sockets_.front() && !is_discovery) continue;

    const auto answered = answer(packet, from);
    if (!answered.empty()) sockets_.front().send(answered, from);
  }
}

std::vector<std::pair<int, sockaddr_in>> udp_sockets() {
  std::vector<std::pair<int, sockaddr_in>> sockets;
  std::error_code gone;
  // Every open file of the process; getsockopt fails unless it is a socket.
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", gone)) {
    const int descriptor = number_in<int>(entry.path().filename().string()).value_or(-1);
    sockaddr_in address{};
    int type = 0;
    socklen_t size = sizeof(type), length = sizeof(address);

    if (::getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_DGRAM &&
        ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &length) == 0 &&
        address.sin_family == AF_INET) {
      sockets.emplace_back(descriptor, address);
    }
  }

  return sockets;
}

bool pass_pictures_only(const PictureStream& stream) {
  auto lines = picture_filter(stream);

  // Attach the filter to the socket that receives the stream.
  const sock_fprog program{static_cast<unsigned short>(lines.size()), lines.data()};
  const auto sockets = udp_sockets();
  const auto socket = std::ranges::find_if(
      sockets, [&](const auto& each) { return ntohs(each.second.sin_port) == stream.port; });
  return socket != sockets.end() &&
         ::setsockopt(socket->first, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof(program)) == 0;
}

}  // namespace slipstream
