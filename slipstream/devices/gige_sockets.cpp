#include "slipstream/devices/gige_sockets.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "slipstream/base/error.h"
#include "slipstream/base/number_bytes.h"

namespace slipstream {
namespace {

constexpr std::uint16_t control_port = 3956;  // of GigE Vision

/// All of 127.x.x.x may be bound on this machine, but a camera is found by an interface's own.
[[noreturn]] void throw_no_interface(const std::string& address) {
  const bool loopback = address.starts_with("127.");
  throw WorldError(
      fmt::format("cannot serve a camera at {}: no network interface has that address; give it to "
                  "one first, as with: sudo ip address add {} dev {}",
                  address, address + (loopback ? "/8" : "/24"), loopback ? "lo" : "INTERFACE"));
}

/// Where what is meant for all goes on the network of the interface that has that address.
in_addr broadcast_of(const std::string& address) {
  const in_addr host = host_from(address);
  const auto host_of = [](const sockaddr* end) {
    return reinterpret_cast<const sockaddr_in*>(end)->sin_addr.s_addr;
  };
  ifaddrs* first = nullptr;
  ::getifaddrs(&first);
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> all(first, &::freeifaddrs);
  for (const ifaddrs* each = first; each != nullptr; each = each->ifa_next) {
    const bool has_address = each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET;
    if (!has_address || host_of(each->ifa_addr) != host.s_addr) continue;
    const in_addr broadcast{host.s_addr | ~host_of(each->ifa_netmask)};
    return broadcast.s_addr == host.s_addr ? in_addr{INADDR_BROADCAST} : broadcast;
  }
  throw_no_interface(address);
}

bool is_discovery(std::span<const std::uint8_t> packet) {
  constexpr std::uint16_t discovery = 0x02;
  return packet.size() >= 4 && number_at<std::uint16_t, std::endian::big>(packet, 2) == discovery;
}

}  // namespace

in_addr host_from(const std::string& address) {
  in_addr host{};
  if (::inet_pton(AF_INET, address.c_str(), &host) == 1) return host;
  throw Error(fmt::format("{} is no address as 127.0.0.1", address));
}

UdpSocket::UdpSocket(in_addr host, std::uint16_t port, bool shared)
    : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const int share = shared ? 1 : 0;
  ::setsockopt(descriptor_, SOL_SOCKET, SO_REUSEADDR, &share, sizeof(share));
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  at.sin_addr = host;
  if (::bind(descriptor_, reinterpret_cast<const sockaddr*>(&at), sizeof(at)) == 0) return;
  const std::string reason = std::strerror(errno);
  if (descriptor_ >= 0) ::close(descriptor_);
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
    if (&socket != &sockets_.front() && !is_discovery(packet)) continue;
    const auto answered = answer(packet, from);
    if (!answered.empty()) sockets_.front().send(answered, from);
  }
}

}  // namespace slipstream
