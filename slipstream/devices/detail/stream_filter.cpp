#include "slipstream/devices/detail/stream_filter.h"

#include <array>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include <arpa/inet.h>
#include <linux/filter.h>
#include <sys/socket.h>

namespace slipstream {
namespace {

/// The process's socket of that port.
std::optional<int> udp_socket(std::uint16_t port) {
  std::error_code gone;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", gone)) {
    const std::string name = entry.path().filename().string();
    int descriptor = -1;
    std::from_chars(name.data(), name.data() + name.size(), descriptor);
    int type = 0;
    socklen_t size = sizeof(type);
    if (::getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) {
      continue;
    }
    sockaddr_in address{};
    size = sizeof(address);
    if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
        address.sin_family == AF_INET && ntohs(address.sin_port) == port) {
      return descriptor;
    }
  }
  return std::nullopt;
}

// Steps of the kernel's filters. A load from past the packet's end drops it.
constexpr unsigned short load_word = BPF_LD | BPF_W | BPF_ABS, load_byte = BPF_LD | BPF_B | BPF_ABS;
constexpr unsigned short load_length = BPF_LD | BPF_W | BPF_LEN, set_offset = BPF_LDX | BPF_IMM;
constexpr unsigned short load_half_there = BPF_LD | BPF_H | BPF_IND;
constexpr unsigned short load_byte_there = BPF_LD | BPF_B | BPF_IND;
constexpr unsigned short keep = BPF_ST, load_kept = BPF_LD | BPF_MEM, give = BPF_RET | BPF_K;
constexpr unsigned short mask = BPF_ALU | BPF_AND | BPF_K, add = BPF_ALU | BPF_ADD | BPF_K;
constexpr unsigned short negate = BPF_ALU | BPF_NEG, go_on = BPF_JMP | BPF_JA;
constexpr unsigned short if_equal = BPF_JMP | BPF_JEQ | BPF_K, if_set = BPF_JMP | BPF_JSET | BPF_K;
constexpr unsigned short if_beyond_offset = BPF_JMP | BPF_JGT | BPF_X;

}  // namespace

bool pass_pictures_only(const PictureStream& stream) {
  constexpr auto sender = static_cast<std::uint32_t>(SKF_NET_OFF) + 12;
  constexpr std::uint32_t udp = 8, kind = udp + 4, long_numbers = 0x80, kinds = 0x7f;
  constexpr std::uint32_t leader = 1, trailer = 2, pixels = 3, picture = 1, leader_bytes = 36;
  constexpr std::uint32_t negative = 0x80000000;
  // The trailer comes after all packets of pixels, which have numbers from 1.
  const auto trailer_number = [&](std::uint32_t header) {
    const std::uint32_t each = stream.packet_size - 20 - udp - header;  // 20: of the internet
    return (stream.picture_bytes + each - 1) / each + 1;
  };
  // An offset ends the header. Jumps count the lines between: where it holds, and where not. What
  // is kept is how many packets are to come after this one.
  std::array<sock_filter, 31> lines{{{load_word, 0, 0, sender},
                                     {if_equal, 0, 28, stream.camera},
                                     {set_offset, 0, 0, udp + 8},
                                     {load_byte, 0, 0, kind},
                                     {if_set, 5, 0, long_numbers},
                                     {load_word, 0, 0, kind},
                                     {mask, 0, 0, 0x00ffffff},
                                     {negate, 0, 0, 0},
                                     {add, 0, 0, trailer_number(8)},
                                     {go_on, 0, 0, 5},
                                     {set_offset, 0, 0, udp + 20},
                                     {load_word, 0, 0, udp + 16},
                                     {if_set, 17, 0, negative},
                                     {negate, 0, 0, 0},
                                     {add, 0, 0, trailer_number(20)},
                                     {if_set, 14, 0, negative},
                                     {keep, 0, 0, 0},
                                     {load_length, 0, 0, 0},
                                     {if_beyond_offset, 0, 11, 0},
                                     {load_byte, 0, 0, kind},
                                     {mask, 0, 0, kinds},
                                     {if_equal, 7, 0, trailer},
                                     {if_equal, 0, 2, pixels},
                                     {load_kept, 0, 0, 0},
                                     {if_equal, 5, 4, 0},
                                     {if_equal, 0, 4, leader},
                                     {load_byte_there, 0, 0, leader_bytes - 1},
                                     {load_half_there, 0, 0, 2},
                                     {if_equal, 0, 1, picture},
                                     {give, 0, 0, 0xffffffff},
                                     {give, 0, 0, 0}}};
  const sock_fprog program{static_cast<unsigned short>(lines.size()), lines.data()};
  const std::optional<int> socket = udp_socket(stream.port);
  return socket &&
         ::setsockopt(*socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof(program)) == 0;
}

}  // namespace slipstream
