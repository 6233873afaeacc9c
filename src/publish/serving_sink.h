#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>  // missing from Boost 1.74
#include <vector>

#include <boost/asio.hpp>
#include <fmt/format.h>

#include "base/thread_priority.h"
#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"

namespace slipstream {

/// A sink that serves clients over TCP, in a thread of its own: everything except `put` and
/// `finish` runs there. A Client is in `clients` while it lives; its look_for_cloud() is called at
/// a cloud after wait_for_cloud(). A derived class calls begin() at the end of its constructor and
/// finish() in its destructor.
template <class Client>
class ServingSink : public CloudSink {
 public:
  using Tcp = boost::asio::ip::tcp;

  void put(const Pooled<LiveCloud>& cloud, bool /*alone*/) final {
    {
      const std::lock_guard lock(mutex_);
      newest_ = cloud;
      ++count_;
    }
    if (anybody_waits_.exchange(false)) boost::asio::post(io_, [this] { serve_waiting(); });
  }

  void finish() final {
    io_.stop();
    if (thread_.joinable()) thread_.join();
    const std::lock_guard lock(mutex_);
    newest_ = {};
  }

  using CloudSink::tell;

  /// Call it before newest(), as a cloud may come between the two.
  void wait_for_cloud() { anybody_waits_ = true; }

  /// Oldest first. Before io_, whose end destroys the clients, which then leave this list.
  std::vector<Client*> clients{};

 protected:
  /// Throws WorldError, naming the kind of sink, if the port is taken.
  ServingSink(const Tcp::endpoint& endpoint, std::string_view kind) try {
    acceptor_ = Tcp::acceptor(io_, endpoint);
  } catch (const boost::system::system_error& error) {
    throw WorldError(fmt::format("`publish {}:{}:{}`: {}", kind, endpoint.address().to_string(),
                                 endpoint.port(), error.code().message()));
  }

  void begin() {
    accept();
    thread_ = std::thread([this] { serve(); });
  }

  virtual void take_client(Tcp::socket socket) = 0;

  void serve_waiting() {
    for (Client* const client : clients) client->look_for_cloud();
  }

  /// The newest cloud, null before the first, and the number of clouds so far.
  std::pair<Pooled<LiveCloud>, std::uint64_t> newest() {
    const std::lock_guard lock(mutex_);
    return {newest_, count_};
  }

  [[nodiscard]] int port() const { return acceptor_.local_endpoint().port(); }

  boost::asio::io_context io_{1};

 private:
  void accept() {
    acceptor_.async_accept([this](boost::system::error_code failure, Tcp::socket socket) {
      if (failure) {  // out of file descriptors
        tell(failure.message());
        pause_.expires_after(std::chrono::milliseconds(100));
        pause_.async_wait([this](boost::system::error_code) { accept(); });
        return;
      }

      // The next client may connect while this one is served.
      accept();
      socket.set_option(Tcp::no_delay(true), failure);
      take_client(std::move(socket));
    });
  }

  void serve() {
    let_others_go_first();
    while (true) {
      try {
        io_.run();
        return;
      } catch (const std::exception& error) {  // ends only this client
        tell(error.what());
      }
    }
  }

  std::mutex mutex_;  ///< guards the two members below
  Pooled<LiveCloud> newest_;
  std::uint64_t count_ = 0;

  std::atomic<bool> anybody_waits_ = false;
  Tcp::acceptor acceptor_{io_};
  boost::asio::steady_timer pause_{io_};
  std::thread thread_;
};

}  // namespace slipstream
