#pragma once

#include <string>
#include <string_view>

#include <boost/asio/ip/tcp.hpp>

// Who may use the page.
namespace slipstream {

/// Parses "PORT" or "ADDRESS:PORT", e.g. "8080", "0.0.0.0:8080", "[::1]:8080". Port 0: any free
/// port. `kind`: of the sink, in messages. Throws Error for any other text.
boost::asio::ip::tcp::endpoint web_endpoint_from(const std::string& where,
                                                 const std::string& kind = "web");

/// A random text that other machines must know to use the page.
std::string random_token();

/// The parts of a request that decide whether it is answered.
struct AccessRequest {
  std::string_view host;    ///< the address that the browser opened
  std::string_view origin;  ///< of the script that sends it; empty without one
  std::string_view target;  ///< path and token
  bool changes = false;     ///< it may change anything, or opens the WebSocket
};

/// Why the request is refused; empty for the page itself and authorised clients. `address`: the
/// page's, as a number; `token`: empty if only this machine reaches the page.
std::string refusal_of(const AccessRequest& request, std::string_view address,
                       std::string_view token);

}  // namespace slipstream
