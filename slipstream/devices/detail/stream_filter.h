#pragma once

#include <cstdint>

namespace slipstream {

/// Where a GigE Vision camera's pictures come from and go to.
struct PictureStream {
  std::uint16_t port = 0;           ///< of a UDP socket of this process
  std::uint32_t camera = 0;         ///< its IPv4 address, in the host's byte order
  std::uint32_t packet_size = 0;    ///< as on the wire, with all its headers: 100 or more
  std::uint32_t picture_bytes = 0;  ///< of the buffers that it goes to
};

/// From now on the kernel hands the socket only what the camera sends of pictures, and no packet of
/// a number that they do not reach. Aravis 0.8.26 takes packets of any sender, writes past its
/// buffers for numbers too large, and takes the sizes of other payloads as they come. Returns false
/// where there is no such socket.
bool pass_pictures_only(const PictureStream& stream);

}  // namespace slipstream
