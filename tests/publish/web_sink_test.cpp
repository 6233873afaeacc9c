#include <array>
#include <cstdint>
#include <string>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "slipstream/cloud_sink.h"
#include "tests/publish/any_cloud.h"

namespace slipstream::web_sink_test {

/// A page's WebSocket, which asks for one cloud after the other.
class Page {
 public:
  explicit Page(std::uint16_t port) {
    const timeval patience{.tv_sec = 10, .tv_usec = 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));

    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof(to)), 0);

    send(
        "GET /clouds HTTP/1.1\r\nHost: localhost\r\nOrigin: http://localhost\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n");
    while (!taken_.ends_with("\r\n\r\n") && receive(1)) {
    }
  }
  ~Page() { ::close(socket_); }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  /// Whether a cloud of a few kB comes in time.
  bool gets_cloud() {
    send(std::string("\x81\x84\0\0\0\0next", 10));
    taken_.clear();
    if (!receive(4)) return false;
    const auto byte = [&](std::size_t n) { return static_cast<unsigned char>(taken_[n]); };
    return byte(1) == 126 && receive(256U * byte(2) + byte(3));
  }

 private:
  void send(const std::string& text) const {
    EXPECT_EQ(::send(socket_, text.data(), text.size(), 0), static_cast<ssize_t>(text.size()));
  }

  bool receive(std::size_t count) {
    std::string bytes(count, '\0');
    const ssize_t come = ::recv(socket_, bytes.data(), count, MSG_WAITALL);
    taken_ += bytes;
    return come == static_cast<ssize_t>(count);
  }

  const int socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
  std::string taken_;
};

TEST(WebSink, SendsTheLastCloudBeforeAPauseToo) {
  const auto sink = open_sink("web:0", {.camera = camera()});
  const std::string address = sink->news().front();  // http://127.0.0.1:PORT/
  Page page(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  for (std::uint64_t number = 0; number < 3; ++number) {
    sink->put(any_cloud(number), false);
    ASSERT_TRUE(page.gets_cloud()) << number;
  }
}

}  // namespace slipstream::web_sink_test
