// What a browser sends to the page of a run: requests, and messages of its WebSocket; and what a
// controller asks.
#include <array>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>

#include "io/file.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"
#include "tests/fuzz/target.h"

namespace slipstream {
namespace {

/// The page of a run without points, or its place for controllers.
class ServedPage {
 public:
  explicit ServedPage(const std::string& kind) {
    try {
      sink_ = open_sink(kind + ":0", {.has_points = false,
                                      .statistics = [] { return R"({"frames": 1})"; },
                                      .trouble = [] { return ""; },
                                      .save = [] { return "a.ply"; },
                                      .settings = [] { return std::vector<RunSetting>(); },
                                      .change = [](const std::string&, const std::string&) {}});
      const std::string address = sink_->news().front();  // http://127.0.0.1:PORT/
      port_ = static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
    } catch (const WorldError&) {  // the machine has no network
    }
  }

  /// Sends bytes and returns all that comes until the page ends the connection.
  std::string answer_to(std::span<const std::uint8_t> bytes) {
    const Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (port_ == 0 || !connect(socket)) return "";

    // The page may end the connection before it has read everything.
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) break;
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
    }
    ::shutdown(socket, SHUT_WR);

    std::string answer;
    std::array<char, 4096> part{};
    while (true) {
      const ssize_t got = ::recv(socket, part.data(), part.size(), 0);
      if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
        throw std::logic_error("a connection stays open that has no more to say");
      }
      if (got <= 0) return answer;
      answer.append(part.data(), static_cast<std::size_t>(got));
    }
  }

 private:
  /// Each time from another address of this machine: each has its own free ports.
  bool connect(int socket) {
    const timeval patience{.tv_sec = 15, .tv_usec = 0};
    ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));

    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK + 1 + clients_++ % 200);
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    if (::bind(socket, any, sizeof(address)) != 0) return false;

    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port_);
    return ::connect(socket, any, sizeof(address)) == 0;
  }

  std::unique_ptr<CloudSink> sink_;
  std::uint16_t port_ = 0;
  std::uint32_t clients_ = 0;
};

ServedPage& served_page() {
  static ServedPage page("web");
  return page;
}

const std::string upgrade =
    "GET /clouds HTTP/1.1\r\nHost: localhost\r\nOrigin: http://localhost\r\n"
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n";

std::vector<Bytes> requests() {
  const std::string local = " HTTP/1.1\r\nHost: localhost\r\nOrigin: http://localhost\r\n";
  return {bytes_of("GET /" + local + "\r\n"),
          bytes_of("GET /settings" + local + "\r\nGET /metrics" + local + "\r\n"),
          bytes_of("POST /settings" + local + "Content-Length: 17\r\n\r\nmin-modulation=20"),
          bytes_of("POST /settings" + local +
                   "Transfer-Encoding: chunked\r\n\r\n3\r\na=b\r\n0\r\n\r\n"),
          bytes_of("POST /save" + local + "Content-Length: 0\r\nConnection: close\r\n\r\n"),
          bytes_of(std::string("GET /health HTTP/1.0\r\nHost: [::1]:80\r\n\r\n")),
          bytes_of(upgrade)};
}

/// Masked messages of text and bytes, a ping, and one in two parts.
std::vector<Bytes> page_messages() {
  const std::string mask("\0\0\0\0", 4);
  return {bytes_of("\x81\x84" + mask + "next\x82\x8a" + mask + "next phase"),
          bytes_of("\x89\x82" + mask + "hi\x88\x80" + mask),
          bytes_of("\x01\x82" + mask + "ne\x80\x82" + mask + "xt")};
}

void answer_requests_of_browser(std::span<const std::uint8_t> input) {
  const std::string answer = served_page().answer_to(input);
  if (!answer.empty() && !answer.starts_with("HTTP/1.")) throw std::logic_error("not HTTP");
}

void answer_messages_of_page(std::span<const std::uint8_t> input) {
  Bytes bytes = bytes_of(upgrade);
  bytes.insert(bytes.end(), input.begin(), input.end());
  const std::string answer = served_page().answer_to(bytes);
  if (!answer.empty() && !answer.starts_with("HTTP/1.1 101"))
    throw std::logic_error("no WebSocket");
}

std::vector<Bytes> controller_requests() {
  std::vector<Bytes> requests;
  for (const std::string lines : {"{\"do\": \"status\"}\n{\"do\": \"pose\", \"id\": 3}\n",
                                  "{\"do\": \"scan\", \"timeout\": 0.1}\r\n{\"do\": \"save\"}\n",
                                  "{\"do\": \"set\", \"name\": \"exposure\", \"value\": 8}\n",
                                  "{\"do\": \"cloud\", \"format\": \"pcd\"}\n"}) {
    requests.push_back(bytes_of(lines));
  }
  return requests;
}

/// Each answer is a line of JSON that says whether it is one.
void answer_controller(std::span<const std::uint8_t> input) {
  static ServedPage place("tcp");
  std::istringstream answer(place.answer_to(input));
  for (std::string line; std::getline(answer, line);) {
    const auto document = nlohmann::json::parse(line, nullptr, false);
    if (!document.is_object() || !document.contains("ok")) throw std::logic_error("no answer");
  }
}

// A kilobyte and more for each connection.
const bool knows_web_targets =
    add_fuzz_target({"http", requests, answer_requests_of_browser, 8}, 10'000) &&
    add_fuzz_target({"websocket", page_messages, answer_messages_of_page, 8}, 10'000) &&
    add_fuzz_target({"controller", controller_requests, answer_controller, 8}, 10'000);

}  // namespace
}  // namespace slipstream
