#include "slipstream/camera/detail/udp_socket.h"

#include <array>
#include <cerrno>
#include <cstring>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

sockaddr_in native(UdpAddress address) {
  sockaddr_in result{};
  result.sin_family = AF_INET;
  result.sin_port = htons(address.port);
  result.sin_addr.s_addr = htonl(address.host);
  return result;
}

}  // namespace

UdpSocket::UdpSocket(UdpAddress address, bool shared)
    : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const int share = shared ? 1 : 0;
  ::setsockopt(descriptor_, SOL_SOCKET, SO_REUSEADDR, &share, sizeof(share));
  const sockaddr_in wanted = native(address);
  if (::bind(descriptor_, reinterpret_cast<const sockaddr*>(&wanted), sizeof(wanted)) == 0) return;
  const int reason = errno;
  if (descriptor_ >= 0) ::close(descriptor_);
  std::array<char, INET_ADDRSTRLEN> host{};
  ::inet_ntop(AF_INET, &wanted.sin_addr, host.data(), host.size());
  throw WorldError(fmt::format("cannot listen on UDP port {} of {}: {}", address.port, host.data(),
                               std::strerror(reason)));
}

UdpSocket::~UdpSocket() {
  ::close(descriptor_);
}

std::span<const std::uint8_t> UdpSocket::receive(std::span<std::uint8_t> room,
                                                 UdpAddress& from) const {
  sockaddr_in sender{};
  socklen_t size = sizeof(sender);
  const ssize_t length = ::recvfrom(descriptor_, room.data(), room.size(), MSG_DONTWAIT | MSG_TRUNC,
                                    reinterpret_cast<sockaddr*>(&sender), &size);
  from = {ntohl(sender.sin_addr.s_addr), ntohs(sender.sin_port)};
  if (length < 0 || static_cast<std::size_t>(length) > room.size()) return {};
  return room.first(static_cast<std::size_t>(length));
}

void UdpSocket::send(std::span<const std::uint8_t> packet, UdpAddress to) const {
  const sockaddr_in receiver = native(to);
  ::sendto(descriptor_, packet.data(), packet.size(), 0,
           reinterpret_cast<const sockaddr*>(&receiver), sizeof(receiver));
}

}  // namespace slipstream
