#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>  // missing from Boost 1.74
#include <vector>

#include <boost/asio.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <nlohmann/json.hpp>

#include "base/throw_if-inl.h"
#include "publish/serving_sink.h"
#include "publish/sink_kind.h"
#include "publish/web_access.h"
#include "slipstream/cloud_file.h"

namespace slipstream {
namespace {
namespace asio = boost::asio;
using asio::ip::tcp;
using namespace std::chrono_literals;
using nlohmann::json;
using std::chrono::steady_clock;
using Failure = boost::system::error_code;

constexpr std::size_t most_controllers = 8, longest_line = 1024;
constexpr auto reply_patience = 30s;
constexpr double default_wait = 10, longest_wait = 60;  // s, for a scan

/// An answer's line, and bytes that follow it.
struct Answer {
  json line;
  std::string bytes{};
};

Answer refused(std::string_view why) {
  return {{{"ok", false}, {"error", why}}};
}

/// A copy of a cloud whose frames were all received after a request.
struct TakenScan {
  FrameStamp newest{};  ///< of its frames
  ValidityCounts counts{};
  Cloud cloud{};
};

/// Whether all frames were received after that time.
bool is_received_after(const LiveCloud& cloud, steady_clock::time_point time) {
  return std::ranges::all_of(cloud.frames,
                             [&](const auto& frame) { return frame->stamp.host_time >= time; });
}

class Controller;

class TcpSink final : public ServingSink<Controller> {
 public:
  TcpSink(const tcp::endpoint& endpoint, PublishedRun run);
  ~TcpSink() override { finish(); }

  /// A copy of the newest cloud if its frames were received after that time; otherwise null.
  std::shared_ptr<const TakenScan> scan_since(steady_clock::time_point time) {
    wait_for_cloud();
    const Pooled<LiveCloud> cloud = newest().first;
    if (!cloud || !is_received_after(*cloud, time)) return nullptr;

    // Controllers that wait for the same cloud share its copy.
    if (!taken_ || taken_->newest.host_time != cloud->newest.host_time) {
      taken_ = std::make_shared<const TakenScan>(
          TakenScan{cloud->newest, count_by_validity(cloud->points()), cloud->points()});
    }
    return taken_;
  }

  /// The answer to a request that needs no wait. `scan`: the controller's last; may be null.
  Answer answer(const json& request, const TakenScan* scan) {
    const std::string wish = request.value("do", "");
    if (wish == "status") return {status()};
    if (wish == "pose") return {pose()};
    if (wish == "cloud") return cloud_of(request, scan);
    if (wish == "save") return {{{"ok", true}, {"folder", run_.save()}}};
    if (wish == "set") {
      const json& value = request.at("value");
      run_.change(request.at("name").get<std::string>(),
                  value.is_string() ? value.get<std::string>() : value.dump());
      return {{{"ok", true}}};
    }
    throw Error(
        fmt::format("\"do\": \"{}\" is unknown; expected scan, cloud, pose, status, set or "
                    "save",
                    wish));
  }

  [[nodiscard]] bool has_points() const { return run_.has_points; }

 private:
  void take_client(tcp::socket socket) override;

  json status() { return {{"ok", true}, {"trouble", run_.trouble()}, {"clouds", newest().second}}; }

  /// The shape that `track` follows.
  json pose() {
    const json statistics = json::parse(run_.statistics());
    throw_if(!statistics.contains("track"), "no shape is followed; name one with `track`");
    return {{"ok", true}, {"track", statistics["track"]}};
  }

  [[nodiscard]] Answer cloud_of(const json& request, const TakenScan* scan) const {
    throw_if(scan == nullptr, "no scan yet; ask for one by {{\"do\": \"scan\"}}");
    const std::string format = request.value("format", "ply");
    std::string bytes = cloud_bytes("." + format, scan->cloud, {.frame = run_.frame});
    return {{{"ok", true}, {"format", format}, {"bytes", bytes.size()}}, std::move(bytes)};
  }

  const PublishedRun run_;
  std::shared_ptr<const TakenScan> taken_;  ///< the last copy
};

/// One client, whose requests are answered one after the other.
class Controller : public std::enable_shared_from_this<Controller> {
 public:
  Controller(tcp::socket socket, TcpSink& sink)
      : stream_(std::move(socket)),
        patience_(stream_.get_executor()),
        sink_(sink),
        clients_(sink.clients) {
    clients_.push_back(this);
  }

  ~Controller() { std::erase(clients_, this); }

  [[nodiscard]] steady_clock::time_point last_asked() const { return last_asked_; }
  void close() {
    patience_.cancel();
    stream_.close();
  }

  void read_request() {
    stream_.expires_never();
    asio::async_read_until(stream_, asio::dynamic_buffer(input_, longest_line), '\n',
                           [self = shared_from_this()](Failure failure, std::size_t size) {
                             self->take_line(failure, size);
                           });
  }

  /// Answers a waiting request if a cloud has come.
  void look_for_cloud() {
    if (!waits_since_) return;
    const auto scan = sink_.scan_since(*waits_since_);
    if (!scan) return;

    waits_since_.reset();
    patience_.cancel();
    scan_ = scan;
    send({{{"ok", true},
           {"frame", scan->newest.sequence},
           {"points", scan->counts.front()},
           {"width", scan->cloud.size().width},
           {"height", scan->cloud.size().height}}});
  }

 private:
  void take_line(Failure failure, std::size_t size) {
    id_ = nullptr;
    if (failure == asio::error::not_found) {  // the buffer is full
      return end(fmt::format("a request is a line of at most {} bytes", longest_line));
    }
    if (failure) return;

    const std::string line = input_.substr(0, size);
    input_.erase(0, size);
    last_asked_ = steady_clock::now();

    // A browser's script may send such lines to this machine, but only after those of HTTP.
    const json request = json::parse(line, nullptr, false);
    if (!request.is_object()) return end("a request is a JSON object in one line");

    try {
      id_ = request.value("id", json());
      if (request.value("do", "") == "scan") return begin_scan(request);
      send(sink_.answer(request, scan_.get()));
    } catch (const json::exception&) {
      send(refused("a value is missing or of another type"));
    } catch (const std::exception& error) {
      send(refused(error.what()));
    }
  }

  void begin_scan(const json& request) {
    throw_if(!sink_.has_points(), "no scanner is known, so there are no points");
    const double wait = request.value("timeout", default_wait);
    throw_if(!(wait > 0 && wait <= longest_wait), "timeout {}: expected seconds, at most {:g}",
             wait, longest_wait);

    waits_since_ = steady_clock::now();
    patience_.expires_after(std::chrono::microseconds(static_cast<std::int64_t>(1e6 * wait)));
    patience_.async_wait([self = shared_from_this(), wait](Failure failure) {
      if (failure || !self->waits_since_) return;
      self->waits_since_.reset();
      self->send(refused(fmt::format("no cloud within {:g} s", wait)));
    });
    look_for_cloud();
  }

  void send(Answer answer) {
    if (!id_.is_null()) answer.line["id"] = id_;
    answer_ =
        answer.line.dump(-1, ' ', false, json::error_handler_t::replace) + "\n" + answer.bytes;

    stream_.expires_after(reply_patience);
    asio::async_write(stream_, asio::buffer(answer_),
                      [self = shared_from_this()](Failure failure, std::size_t) {
                        self->answer_ = {};
                        if (!failure && !self->ends_) self->read_request();
                      });
  }

  /// Says why, and closes the connection.
  void end(std::string_view why) {
    ends_ = true;
    send(refused(why));
  }

  boost::beast::tcp_stream stream_;
  asio::steady_timer patience_;
  TcpSink& sink_;
  std::vector<Controller*>& clients_;  ///< for the destructor, which may run after the sink's
  std::string input_, answer_;
  json id_;
  bool ends_ = false;
  steady_clock::time_point last_asked_ = steady_clock::now();
  std::optional<steady_clock::time_point> waits_since_;  ///< time of a request for a scan
  std::shared_ptr<const TakenScan> scan_;                ///< the last one asked for
};

TcpSink::TcpSink(const tcp::endpoint& endpoint, PublishedRun run)
    : ServingSink(endpoint, "tcp"), run_(std::move(run)) {
  const std::string host = endpoint.address().to_string();
  tell(fmt::format("tcp://{}:{}", endpoint.address().is_v6() ? "[" + host + "]" : host, port()));
  begin();
}

void TcpSink::take_client(tcp::socket socket) {
  // The one that has not asked for longest makes room.
  if (clients.size() >= most_controllers) {
    const auto silent = std::ranges::min_element(clients, {}, &Controller::last_asked);
    (*silent)->close();
    tell(fmt::format("at most {} controllers at a time; the most silent one is disconnected",
                     most_controllers));
  }
  std::make_shared<Controller>(std::move(socket), *this)->read_request();
}

}  // namespace

const SinkKind tcp_sink{
    "tcp", "tcp:[ADDRESS:]PORT",
    [](const std::string& where) { static_cast<void>(web_endpoint_from(where, "tcp")); },
    [](const std::string& where, PublishedRun run) -> std::unique_ptr<CloudSink> {
      return std::make_unique<TcpSink>(web_endpoint_from(where, "tcp"), std::move(run));
    }};

}  // namespace slipstream
