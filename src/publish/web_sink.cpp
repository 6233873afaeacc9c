#include <algorithm>
#include <array>
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
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>

#include "base/printable.h"
#include "base/throw_if-inl.h"
#include "publish/serving_sink.h"
#include "publish/sink_kind.h"
#include "publish/web_access.h"
#include "publish/web_content.h"
#include "slipstream/image.h"

namespace slipstream {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunSetting, name, help, unit, value, choices, least, most, state)

namespace {
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using namespace std::chrono_literals;
using Failure = boost::system::error_code;
using Request = http::request<http::string_body>;
using WebResponse = http::response<http::string_body>;
using SharedBytes = std::shared_ptr<const std::string>;

/// Clients at a time, and of one address those that have sent no authorised request yet.
constexpr std::size_t most_clients = 32, most_unknown = 8;
constexpr std::size_t largest_header = 8 << 10, largest_body = 256, largest_message = 64;
/// Time limit for a client's request and for reading the reply.
constexpr auto patience = 10s, answer_patience = 30s;
constexpr std::chrono::milliseconds between_clouds{30}, between_looks{200};

std::string_view text_of(beast::string_view text) {
  return {text.data(), text.size()};
}

class Connection;

class WebSink final : public ServingSink<Connection> {
 public:
  WebSink(const tcp::endpoint& endpoint, PublishedRun run);
  ~WebSink() override { finish(); }

  /// Why the request is refused; empty for the page itself and authorised clients.
  [[nodiscard]] std::string refusal(const Request& request) const {
    return refusal_of(
        {.host = text_of(request[http::field::host]),
         .origin = text_of(request[http::field::origin]),
         .target = text_of(request.target()),
         .changes = request.method() != http::verb::get || websocket::is_upgrade(request)},
        host_, token_);
  }

  /// `full`: only /health is answered.
  WebResponse answer(const Request& request, bool full) {
    WebResponse response(http::status::ok, request.version());

    // Headers that every answer has.
    response.keep_alive(request.keep_alive());
    response.set(http::field::cache_control, "no-store");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");

    // Method and path, without the token.
    const std::string_view target = text_of(request.target());
    const auto method_and_path =
        fmt::format("{} {}", text_of(request.method_string()), target.substr(0, target.find('?')));

    try {
      if (const std::string why = refusal(request); !why.empty()) {
        say(response, http::status::forbidden, why + "\n");
        response.keep_alive(false);
      } else if (full && method_and_path != "GET /health") {
        tell(fmt::format("at most {} clients at a time; further ones are refused", most_clients));
        say(response, http::status::service_unavailable, "too many clients\n");
      } else {
        dispatch(method_and_path, request.body(), response);
      }
    } catch (const Error& error) {
      say(response, http::status::bad_request, error.what());
    } catch (const std::exception& error) {
      say(response, http::status::internal_server_error, error.what());
    }

    response.prepare_payload();
    return response;
  }

  /// The newest cloud and its number, if newer than the given one.
  std::pair<SharedBytes, std::uint64_t> newer_than(std::uint64_t seen, bool with_phase) {
    const auto now = std::chrono::steady_clock::now();
    // Each kind of message, with the phase or without, is built once for all clients.
    Sent& sent = sent_[with_phase ? 1 : 0];

    const auto [cloud, count] = newest();
    const bool is_new = cloud && count != sent.count;
    // A cloud that comes too soon is replaced by the one after it, if the run goes on.
    if (is_new && now < sent.next) serve_waiting_at(sent.next + between_clouds);
    if (is_new && now >= sent.next) {
      sent.count = count;
      // Tolerates jitter of clouds.
      sent.next = std::max(sent.next + between_clouds, now + between_clouds / 2);

      const bool has_phase = with_phase && run_.phase;
      sent.bytes = std::make_shared<const std::string>(
          web_cloud(*cloud, has_phase ? run_.phase(*cloud) : Image<std::uint8_t>()));
    }

    if (sent.count <= seen) return {};
    return {sent.bytes, sent.count};
  }

 private:
  void take_client(tcp::socket socket) override;
  void make_room(const asio::ip::address& address);
  void serve_waiting_at(std::chrono::steady_clock::time_point time) {
    next_cloud_.expires_at(time);
    next_cloud_.async_wait([this](Failure failure) {
      if (!failure) serve_waiting();
    });
  }

  static void say(WebResponse& response, http::status status, std::string body,
                  const char* type = "text/plain") {
    response.result(status);
    response.set(http::field::content_type, fmt::format("{}; charset=utf-8", type));
    response.body() = type == std::string_view("text/plain") ? printable_lines(body) : body;
  }

  /// Fills the response to an authorised request, e.g. "GET /settings".
  void dispatch(std::string_view method_and_path, const std::string& body, WebResponse& response) {
    using enum http::status;

    // The page, and the tables that it draws with.
    if (method_and_path == "GET /") {
      response.set("Content-Security-Policy", page_rules);
      say(response, ok, std::string(web_page()), "text/html");
    } else if (method_and_path == "GET /rays") {
      say(response, ok, rays_, "application/octet-stream");
    } else if (method_and_path == "GET /palette") {
      say(response, ok, web_palette(), "application/octet-stream");

      // The state of the run, and changes of it.
    } else if (method_and_path == "GET /statistics") {
      say(response, ok, run_.statistics(), "application/json");
    } else if (method_and_path == "GET /metrics") {
      say(response, ok, metrics_of(run_.statistics()), "text/plain; version=0.0.4");
    } else if (method_and_path == "GET /health") {
      const std::string trouble = run_.trouble();
      say(response, trouble.empty() ? ok : service_unavailable,
          (trouble.empty() ? "ok" : trouble) + "\n");
    } else if (method_and_path == "GET /settings") {
      say(response, ok, settings(), "application/json");
    } else if (method_and_path == "POST /settings") {
      change(body);
      say(response, ok, settings(), "application/json");
    } else if (method_and_path == "POST /save") {
      say(response, ok, run_.save());
    } else {
      say(response, not_found, "no such page\n");
    }
  }

  /// Avoids asking the camera for each page.
  const std::string& settings() {
    const auto now = std::chrono::steady_clock::now();
    if (!settings_.empty() && now - looked_at_ < between_looks) return settings_;

    settings_ = nlohmann::json(run_.settings())
                    .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    looked_at_ = now;
    return settings_;
  }

  /// E.g. "minimum-modulation=20".
  void change(const std::string& wish) {
    const std::size_t mark = std::min(wish.find('='), wish.size());
    if (mark == wish.size()) throw Error("expected NAME=VALUE");

    settings_.clear();
    run_.change(wish.substr(0, mark), wish.substr(mark + 1));
  }

  const std::string host_;  ///< the address, as a number
  const PublishedRun run_;

  const std::string token_;  ///< empty if only this machine reaches the page
  const std::string rays_;

  struct Sent {
    SharedBytes bytes{};
    std::uint64_t count = 0;                       ///< the cloud's number
    std::chrono::steady_clock::time_point next{};  ///< earliest time of the next
  };
  std::array<Sent, 2> sent_{};  ///< without phase and with it

  std::chrono::steady_clock::time_point looked_at_{};
  std::string settings_;  ///< at that time

  asio::steady_timer next_cloud_{io_};
};

/// One client: sequential requests, or a page that requests clouds.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  /// `full`: answers one request, for /health.
  Connection(tcp::socket socket, const asio::ip::address& address, WebSink& sink, bool full)
      : stream_(std::move(socket)),
        address_(address),
        sink_(sink),
        clients_(sink.clients),
        full_(full) {
    clients_.push_back(this);
  }

  ~Connection() { std::erase(clients_, this); }

  /// Whether its last request was authorised, and it may send more.
  [[nodiscard]] bool is_known() const { return known_ && !full_; }

  [[nodiscard]] const asio::ip::address& address() const { return address_; }
  /// Ends it before it has sent an authorised request.
  void close() {
    std::erase(clients_, this);
    stream_.close();
  }

  void read_request() {
    parser_.emplace();
    parser_->header_limit(largest_header);
    parser_->body_limit(largest_body);
    stream_.expires_after(patience);

    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](Failure failure, std::size_t) {
                       if (!failure) self->answer();
                     });
  }

  /// Sends the newest cloud if requested and new.
  void look_for_cloud() {
    if (!asked_ || sending_) return;
    sink_.wait_for_cloud();
    auto [bytes, count] = sink_.newer_than(seen_, with_phase_);
    if (!bytes) return;

    asked_ = false;
    sending_ = bytes;
    seen_ = count;

    page_->async_write(asio::buffer(*sending_),
                       [self = shared_from_this()](Failure failure, std::size_t) {
                         self->sending_.reset();
                         if (!self->has_failed(failure)) self->look_for_cloud();
                       });
  }

 private:
  void answer() {
    // A page that asks for clouds becomes a WebSocket; any other request is answered.
    const Request request = parser_->release();
    known_ = sink_.refusal(request).empty();
    if (known_ && !full_ && websocket::is_upgrade(request) &&
        text_of(request.target()).starts_with("/clouds")) {
      open_page(request);
      return;
    }

    response_ = sink_.answer(request, full_);
    if (full_) response_.keep_alive(false);

    stream_.expires_after(answer_patience);
    http::async_write(stream_, response_,
                      [self = shared_from_this()](Failure failure, std::size_t) {
                        if (!failure && self->response_.keep_alive()) self->read_request();
                      });
  }

  void open_page(const Request& request) {
    stream_.expires_never();

    page_.emplace(std::move(stream_));
    page_->set_option(websocket::stream_base::timeout{patience, answer_patience, true});
    page_->read_message_max(largest_message);
    page_->auto_fragment(false);
    page_->binary(true);

    page_->async_accept(request, [self = shared_from_this()](Failure failure) {
      if (!failure) self->read_wish();
    });
  }

  bool has_failed(Failure failure) {
    if (failure == beast::error::timeout) sink_.tell("disconnected a page that stopped reading");
    return failure.failed();
  }

  /// A page only sends "next" or "next phase".
  void read_wish() {
    buffer_.clear();

    page_->async_read(buffer_, [self = shared_from_this()](Failure failure, std::size_t) {
      if (self->has_failed(failure)) return;
      const std::string wish = beast::buffers_to_string(self->buffer_.data());
      self->with_phase_ = wish == "next phase";
      if (wish != "next" && !self->with_phase_) {
        beast::get_lowest_layer(*self->page_).close();
        return;
      }

      self->asked_ = true;
      self->look_for_cloud();
      self->read_wish();
    });
  }

  beast::tcp_stream stream_;
  const asio::ip::address address_;
  WebSink& sink_;
  std::vector<Connection*>& clients_;  ///< for the destructor, which may run after the sink's
  const bool full_;
  bool known_ = false;
  beast::flat_buffer buffer_{2 * largest_header};
  std::optional<http::request_parser<http::string_body>> parser_;
  WebResponse response_;
  std::optional<websocket::stream<beast::tcp_stream>> page_;
  bool asked_ = false, with_phase_ = false;
  SharedBytes sending_;
  std::uint64_t seen_ = 0;  ///< number of the newest cloud sent
};

WebSink::WebSink(const tcp::endpoint& endpoint, PublishedRun run)
    : ServingSink(endpoint, "web"),
      host_(endpoint.address().to_string()),
      run_(std::move(run)),
      token_(endpoint.address().is_loopback() ? "" : random_token()),
      rays_(run_.has_points ? web_rays(run_.camera) : "") {
  // The address to open. Other machines need this one's name, and the token.
  const std::string host = !token_.empty()              ? asio::ip::host_name()
                           : endpoint.address().is_v6() ? "[" + host_ + "]"
                                                        : host_;
  tell(fmt::format("http://{}:{}/{}", host, port(), token_.empty() ? "" : "?token=" + token_));
  begin();
}

void WebSink::take_client(tcp::socket socket) {
  Failure gone_already;
  const auto address = socket.remote_endpoint(gone_already).address();
  make_room(address);

  const bool full = clients.size() >= most_clients;
  std::make_shared<Connection>(std::move(socket), address, *this, full)->read_request();
}

/// Closes the oldest unknown client if there are too many, of this address or altogether.
void WebSink::make_room(const asio::ip::address& address) {
  std::vector<Connection*> unknown, of_address;
  for (Connection* const connection : clients) {
    if (connection->is_known()) continue;
    unknown.push_back(connection);
    if (connection->address() == address) of_address.push_back(connection);
  }

  if (of_address.size() >= most_unknown) {
    of_address.front()->close();
  } else if (clients.size() >= most_clients && !unknown.empty()) {
    unknown.front()->close();
  }
}

}  // namespace

const SinkKind web_sink{
    "web", "web:[ADDRESS:]PORT",
    [](const std::string& where) { static_cast<void>(web_endpoint_from(where)); },
    [](const std::string& where, PublishedRun run) -> std::unique_ptr<CloudSink> {
      return std::make_unique<WebSink>(web_endpoint_from(where), std::move(run));
    }};

}  // namespace slipstream
