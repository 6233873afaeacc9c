#include "publish/web_access.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <string_view>

#include <boost/asio/ip/address.hpp>
#include <fmt/format.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

/// Constant-time comparison.
bool is_same(std::string_view a, std::string_view b) {
  return a.size() == b.size() && std::transform_reduce(a.begin(), a.end(), b.begin(), 0,
                                                       std::bit_or<>(), std::bit_xor<>()) == 0;
}

/// "localhost" from "localhost:8080".
std::string_view without_port(std::string_view host) {
  const std::size_t colon = host.rfind(':');
  return host.ends_with(']') || colon == host.npos ? host : host.substr(0, colon);
}

}  // namespace

boost::asio::ip::tcp::endpoint web_endpoint_from(const std::string& where,
                                                 const std::string& kind) {
  const std::size_t colon = where.rfind(':');
  std::string host = colon == where.npos ? "127.0.0.1" : where.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);

  const auto port = number_in<std::uint16_t>(where.substr(colon + 1));  // all without a colon
  boost::system::error_code failure;
  const auto address = boost::asio::ip::make_address(host, failure);
  throw_if(!port || failure,
           "`publish {0}:{1}`: expected a port, or an IP address of this machine and a port, e.g. "
           "{0}:8080 or {0}:0.0.0.0:8080",
           kind, where);

  return {address, *port};
}

std::string random_token() {
  std::random_device device;  // from the system's random source
  std::string token;
  for (int word = 0; word < 4; ++word) token += fmt::format("{:08x}", device());
  return token;
}

std::string refusal_of(const AccessRequest& request, std::string_view address,
                       std::string_view token) {
  const auto& [host, origin, target, changes] = request;
  const std::string_view name = without_port(host);
  if (token.empty() && name != "localhost" && name != address && name != "[::1]") {
    return "this page is for localhost";  // a foreign host name may resolve to this machine
  }

  if (!token.empty()) {
    const std::size_t question = target.find("?token=");
    if (question == target.npos || !is_same(target.substr(question + 7), token)) {
      return "wrong token; use the full address that slipstream printed at the start";
    }
  }

  // A browser sends the origin of a script: only the page's own may change anything or open the
  // WebSocket.
  const std::size_t scheme = origin.find("://");
  if (changes && (scheme == origin.npos || origin.substr(scheme + 3) != host)) {
    return "another page's script asks";
  }

  return "";
}

}  // namespace slipstream
