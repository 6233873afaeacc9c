#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "io/file.h"
#include "slipstream/cloud_file.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"
#include "tests/io/temporary_folder.h"
#include "tests/publish/any_cloud.h"

namespace slipstream::tcp_sink_test {
using nlohmann::json;

/// A controller's connection.
class Connection {
 public:
  explicit Connection(std::uint16_t port) {
    const timeval patience{.tv_sec = 10, .tv_usec = 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));

    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof(to)), 0);
  }
  ~Connection() { ::close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void send(const std::string& text) const {
    EXPECT_EQ(::send(socket_, text.data(), text.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(text.size()));
  }

  /// The next answer; discarded if the connection has ended.
  [[nodiscard]] json answer() const {
    std::string line;
    for (char c = 0; ::recv(socket_, &c, 1, 0) == 1 && c != '\n';) line += c;
    return json::parse(line, nullptr, false);
  }

  [[nodiscard]] json ask(const std::string& request) const {
    send(request + "\n");
    return answer();
  }

  [[nodiscard]] std::vector<std::uint8_t> bytes(std::size_t count) const {
    std::vector<std::uint8_t> taken(count);
    EXPECT_EQ(::recv(socket_, taken.data(), count, MSG_WAITALL), static_cast<ssize_t>(count));
    return taken;
  }

 private:
  const int socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
};

class TcpSink : public testing::Test {
 protected:
  TcpSink() { open({}); }

  /// Publishes in that frame; null: the camera's.
  void open(std::shared_ptr<const FramePose> frame) {
    sink_ = open_sink(
        "tcp:0", {.camera = camera(),
                  .frame = std::move(frame),
                  .statistics = [] { return R"({"track": {"centre_mm": [1, 2, 3]}})"; },
                  .trouble = [] { return ""; },
                  .save = [] { return "scans/scan-1"; },
                  .change = [this](const std::string& name,
                                   const std::string& value) { changed_ = name + "=" + value; }});
    const std::string address = sink_->news().front();  // tcp://127.0.0.1:PORT
    EXPECT_TRUE(address.starts_with("tcp://127.0.0.1:")) << address;
    port_ = static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
  }

  /// Puts clouds until the test has its answer, as a run does.
  [[nodiscard]] json scan(const Connection& connection) const {
    connection.send("{\"do\": \"scan\"}\n");
    std::jthread run([this](const std::stop_token& stop) {
      for (std::uint64_t number = 10; !stop.stop_requested(); ++number) {
        sink_->put(any_cloud(number), false);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    });
    return connection.answer();
  }

  /// The cloud of the last scan, as a file of so many bytes.
  [[nodiscard]] static Cloud cloud(const Connection& connection, const std::string& format) {
    const json head = connection.ask(R"({"do": "cloud", "format": ")" + format + "\"}");
    EXPECT_EQ(head["ok"], true) << head;
    const TemporaryFolder folder;
    const auto path = folder.path() / ("cloud." + format);
    put_bytes(path, connection.bytes(head["bytes"]));
    return read_cloud(path).cloud;
  }

  std::unique_ptr<CloudSink> sink_;
  std::uint16_t port_ = 0;
  std::string changed_;
};

TEST_F(TcpSink, GivesTheCloudOfFramesTakenAfterTheRequestAndNoOlderOne) {
  sink_->put(any_cloud(1), false);
  const Connection connection(port_);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));

  const json old = connection.ask(R"({"do": "scan", "timeout": 0.05})");
  EXPECT_EQ(old["ok"], false) << "the only cloud came before";

  const json taken = scan(connection);
  ASSERT_EQ(taken["ok"], true) << taken;
  EXPECT_GE(taken["frame"], 10);
  EXPECT_EQ(taken["width"], size.width);

  // The cloud in each format.
  for (const std::string format : {"ply", "pcd", "xyz"}) {
    EXPECT_EQ(point_count(cloud(connection, format)), taken["points"]);
  }
}

TEST_F(TcpSink, GivesThePointsInTheFrameThatTheRunPublishes) {
  const Eigen::Isometry3d pose(Eigen::Translation3d(100, 200, 300));
  open(std::make_shared<const FramePose>(FramePose{"camera", "robot_base", pose}));
  const Connection connection(port_);
  ASSERT_EQ(scan(connection)["ok"], true);

  const Cloud moved = cloud(connection, "pcd");
  EXPECT_EQ(frame_name(moved), "robot_base");
  ASSERT_NE(moved.frame, nullptr);
  EXPECT_TRUE(moved.frame->transform.isApprox(pose, 1e-6));
  for (std::size_t i = 0; i < moved.z.pixel_count(); ++i) {
    if (moved.validity.begin()[i] == Validity::valid) {
      ASSERT_GT(moved.z.begin()[i], 799);
    }
  }
}

// Formats are named as the endings of files, in any case of letters.
TEST_F(TcpSink, GivesTheFormatInCapitalLettersToo) {
  const Connection connection(port_);
  ASSERT_EQ(scan(connection)["ok"], true);
  const json head = connection.ask(R"({"do": "cloud", "format": "PLY"})");
  ASSERT_EQ(head["ok"], true) << head;
  const std::vector<std::uint8_t> bytes = connection.bytes(head["bytes"]);
  ASSERT_GT(bytes.size(), 3U);
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 3), "ply");
}

TEST_F(TcpSink, AnswersTheOtherRequestsWithTheirIdentifier) {
  const Connection connection(port_);
  const json status = connection.ask(R"({"do": "status", "id": 7})");
  EXPECT_EQ(status, json({{"ok", true}, {"trouble", ""}, {"clouds", 0}, {"id", 7}}));
  EXPECT_EQ(connection.ask(R"({"do": "pose"})")["track"]["centre_mm"][2], 3);
  EXPECT_EQ(connection.ask(R"({"do": "save"})")["folder"], "scans/scan-1");
  EXPECT_EQ(connection.ask(R"({"do": "set", "name": "exposure", "value": 8})")["ok"], true);
  EXPECT_EQ(changed_, "exposure=8");

  // Two requests at once are answered in turn.
  connection.send("{\"do\": \"status\", \"id\": 1}\n{\"do\": \"status\", \"id\": 2}\n");
  EXPECT_EQ(connection.answer()["id"], 1);
  EXPECT_EQ(connection.answer()["id"], 2);
}

TEST_F(TcpSink, SaysWhatIsWrongAndGoesOn) {
  const Connection connection(port_);
  const auto refusal = [&](const std::string& request) {
    const json answer = connection.ask(request);
    EXPECT_EQ(answer["ok"], false) << request;
    return answer.value("error", "");
  };

  EXPECT_NE(refusal(R"({"do": "dance"})").find("dance"), std::string::npos);
  EXPECT_NE(refusal(R"({"do": "cloud"})").find("no scan yet"), std::string::npos);
  EXPECT_NE(refusal(R"({"do": "scan", "timeout": 1e9})").find("timeout"), std::string::npos);
  EXPECT_NE(refusal(R"({"do": "scan", "timeout": "x"})").find("type"), std::string::npos);
  EXPECT_NE(refusal(R"({"do": 3})").find("type"), std::string::npos);
  EXPECT_NE(refusal(R"({"do": "set"})").find("missing"), std::string::npos);
  EXPECT_EQ(connection.ask(R"({"do": "status"})")["ok"], true);

  ASSERT_EQ(scan(connection)["ok"], true);
  EXPECT_NE(refusal(R"({"do": "cloud", "format": "stl"})").find("stl"), std::string::npos);
}

TEST_F(TcpSink, RefusesALineWithoutTheIdentifierOfTheRequestBefore) {
  const Connection connection(port_);
  EXPECT_EQ(connection.ask(R"({"do": "status", "id": 7})")["id"], 7);
  const json refusal = connection.ask("no request");
  EXPECT_EQ(refusal["ok"], false);
  EXPECT_FALSE(refusal.contains("id")) << refusal;
}

// A browser's script can make its browser send such lines, after those of HTTP.
TEST_F(TcpSink, EndsAConnectionWhoseLinesAreNoRequests) {
  const std::string deep = std::string(900, '[');
  for (const std::string& line :
       {std::string("POST / HTTP/1.1"), std::string("[]"), std::string("{\"do\": "), deep,
        std::string(2000, 'a'), std::string("\0\xff", 2)}) {
    const Connection connection(port_);
    connection.send(line + "\n{\"do\": \"save\"}\n");
    const json answer = connection.answer();
    EXPECT_TRUE(answer.is_discarded() || answer["ok"] == false) << line;
    EXPECT_TRUE(connection.answer().is_discarded()) << "it has ended";
  }
  EXPECT_EQ(Connection(port_).ask(R"({"do": "status"})")["ok"], true);
}

TEST_F(TcpSink, TakesRequestsOfUpTo1024Bytes) {
  const std::string request = R"({"do": "status"})";
  for (const std::size_t bytes : {1024, 1025}) {  // with the line feed
    const json answer =
        Connection(port_).ask(request + std::string(bytes - 1 - request.size(), ' '));
    EXPECT_EQ(!answer.is_discarded() && answer["ok"] == true, bytes == 1024) << answer;
  }
}

TEST_F(TcpSink, ServesANewControllerInPlaceOfTheMostSilent) {
  const std::string status = R"({"do": "status"})";
  std::vector<std::unique_ptr<Connection>> all;
  for (int i = 0; i < 8; ++i) {
    all.push_back(std::make_unique<Connection>(port_));
    EXPECT_EQ(all.back()->ask(status)["ok"], true);
  }
  EXPECT_EQ(all[0]->ask(status)["ok"], true);

  EXPECT_EQ(Connection(port_).ask(status)["ok"], true);
  EXPECT_TRUE(all[1]->answer().is_discarded());
  EXPECT_EQ(all[0]->ask(status)["ok"], true);

  // Many that never ask.
  for (int i = 0; i < 20; ++i) all.push_back(std::make_unique<Connection>(port_));
  EXPECT_EQ(Connection(port_).ask(status)["ok"], true);
}

TEST_F(TcpSink, RefusesAPlaceThatIsNone) {
  for (const char* wrong : {"tcp:", "tcp:x", "tcp:1.2.3:80", "tcp:99999"}) {
    EXPECT_THROW(require_sink(wrong), Error) << wrong;
  }
  EXPECT_NO_THROW(require_sink("tcp:[::1]:0"));
}

}  // namespace slipstream::tcp_sink_test
