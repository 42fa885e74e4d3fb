#include "server/net/access/gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/ip/network_v4.hpp>
#include <boost/asio/ip/network_v6.hpp>
#include <charconv>

#include "server/net/http/http_fields.h"

namespace foreland::server {
namespace ip = boost::asio::ip;
namespace {

struct Network {
  ip::address address;
  int bits = 0;
};

std::optional<Network> parseNetwork(std::string_view text) {
  const size_t slash = text.find('/');
  boost::system::error_code error;
  const ip::address address = ip::make_address(std::string(text.substr(0, slash)), error);
  if (error) return std::nullopt;
  const int most = address.is_v4() ? 32 : 128;
  int bits = most;
  if (slash != std::string_view::npos) {
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data() + slash + 1, end, bits);
    if (parsed.ec != std::errc() || parsed.ptr != end || bits < 0 || bits > most) return std::nullopt;
  }
  return Network{address, bits};
}

bool contains(const Network& network, const ip::address& address) {
  if (network.address.is_v4() != address.is_v4()) return false;
  const auto bits = static_cast<unsigned short>(network.bits);
  if (address.is_v4())
    return ip::network_v4(address.to_v4(), bits).canonical() ==
           ip::network_v4(network.address.to_v4(), bits).canonical();
  return ip::network_v6(address.to_v6(), bits).canonical() == ip::network_v6(network.address.to_v6(), bits).canonical();
}

// SCHEME://HOST[:PORT], as browsers write it.
bool isOrigin(std::string_view text) {
  const size_t scheme = text.find("://");
  if (scheme == std::string_view::npos || scheme == 0) return false;
  const std::string_view host = text.substr(scheme + 3);
  return !host.empty() && host.find_first_of("/?#@ \t") == std::string_view::npos;
}

// Of "Authorization: Bearer TOKEN", or of the query: pages cannot set headers of WebSockets.
std::string_view tokenOf(const Visitor& visitor) {
  constexpr std::string_view kScheme = "Bearer ", kParameter = "token=";
  if (visitor.authorization.starts_with(kScheme)) return visitor.authorization.substr(kScheme.size());
  size_t at = visitor.target.find('?');
  while (at != std::string_view::npos) {
    const std::string_view rest = visitor.target.substr(at + 1);
    if (rest.starts_with(kParameter))
      return rest.substr(kParameter.size(), rest.find('&') == std::string_view::npos
                                                ? std::string_view::npos
                                                : rest.find('&') - kParameter.size());
    at = visitor.target.find('&', at + 1);
  }
  return {};
}

// Of an element of Forwarded what its `for` says. Any other element is one of X-Forwarded-For: a node itself.
std::string_view nodeOf(std::string_view element) {
  if (element.find('=') == std::string_view::npos) return element;
  while (!element.empty()) {
    const size_t end = std::min(element.find(';'), element.size());
    const std::string_view pair = trimmed(element.substr(0, end));
    const size_t equals = std::min(pair.find('='), pair.size());
    if (equalsIgnoringCase(pair.substr(0, equals), "for")) return pair.substr(std::min(equals + 1, pair.size()));
    element.remove_prefix(std::min(end + 1, element.size()));
  }
  return {};
}

std::string_view withoutQuotes(std::string_view text) {
  return text.size() > 1 && text.front() == '"' && text.back() == '"' ? text.substr(1, text.size() - 2) : text;
}

// Without its port: 192.0.2.1:80, [2001:db8::1]:80 or [2001:db8::1]. IPv6 without brackets has none.
std::string_view hostOf(std::string_view node) {
  if (node.starts_with('[')) {
    const size_t close = node.find(']');
    if (close == std::string_view::npos) return {};
    const std::string_view rest = node.substr(close + 1);
    return rest.empty() || rest.starts_with(':') ? node.substr(1, close - 1) : std::string_view();
  }
  const size_t colon = node.find(':');
  return colon != std::string_view::npos && node.find(':', colon + 1) == std::string_view::npos ? node.substr(0, colon)
                                                                                                : node;
}

// A name that a proxy has made up for an address which it does not tell (RFC 7239, section 6.3).
bool isMadeUpName(std::string_view text) {
  constexpr size_t kLongest = 64;
  constexpr std::string_view kOthers = "._-";
  return text.starts_with('_') && text.size() <= kLongest && std::all_of(text.begin(), text.end(), [&](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  kOthers.find(c) != std::string_view::npos;
         });
}

}  // namespace

std::string addressText(const ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address.to_string();
  return ip::make_address_v4(ip::v4_mapped, address.to_v6()).to_string();
}

std::string networkOf(const std::string& address) {
  boost::system::error_code error;
  const ip::address parsed = ip::make_address(address, error);
  if (error || !parsed.is_v6()) return address;
  return ip::network_v6(parsed.to_v6(), 64).canonical().to_string();
}

Status check(const GateOptions& options) {
  for (const std::string& origin : options.allowed_origins)
    if (!isOrigin(origin))
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("--allow-origin '{}': write SCHEME://HOST[:PORT], such as https://example.org", origin)};
  for (const std::string& proxy : options.trusted_proxies)
    if (!parseNetwork(proxy))
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("--trusted-proxy '{}': write an address or a network, such as 127.0.0.1 or 10.0.0.0/8", proxy)};
  return {};
}

// The server's own page may always connect; who is no browser says no origin.
bool Gate::isAllowed(const Visitor& visitor) const {
  if (options_.allowed_origins.empty() || visitor.origin.empty()) return true;
  const size_t scheme = visitor.origin.find("://");
  if (scheme != std::string_view::npos && visitor.origin.substr(scheme + 3) == visitor.host) return true;
  return std::find(options_.allowed_origins.begin(), options_.allowed_origins.end(), visitor.origin) !=
         options_.allowed_origins.end();
}

std::string Gate::sharesWith(std::string_view origin) const {
  const std::vector<std::string>& allowed = options_.allowed_origins;
  if (allowed.empty()) return "*";
  return std::find(allowed.begin(), allowed.end(), origin) == allowed.end() ? std::string() : std::string(origin);
}

std::variant<Pass, Rejection> Gate::admit(const Visitor& visitor, int64_t now_s) {
  if (!isAllowed(visitor))
    return Rejection{403, RefusedFor::kOrigin, "Pages of that origin may not connect here (--allow-origin)."};
  if (options_.token_secret.empty()) return Pass{};
  const std::string_view text = tokenOf(visitor);
  if (text.empty())
    return Rejection{401, RefusedFor::kToken,
                     "A token is needed: foreland fly --token, or #token= in the page's address."};
  auto token = verifyToken(text, options_.token_secret, now_s);
  if (!token) return Rejection{401, RefusedFor::kToken, fmt::format("Not let in: {}.", token.error().message)};
  std::erase_if(viewers_, [](const auto& entry) { return entry.second.expired(); });
  auto viewers = viewers_[token->name].lock();
  if (!viewers) viewers_[token->name] = viewers = std::make_shared<size_t>();
  if (token->viewers > 0 && static_cast<size_t>(viewers.use_count()) > token->viewers)
    return Rejection{503, RefusedFor::kToken, "As many viewers as the token allows are here already."};
  return Pass{std::move(*token), std::move(viewers)};
}

bool Gate::isTrusted(const std::string& address) const {
  boost::system::error_code error;
  const ip::address parsed = ip::make_address(address, error);
  return !error && std::any_of(options_.trusted_proxies.begin(), options_.trusted_proxies.end(),
                               [&](const std::string& proxy) { return contains(*parseNetwork(proxy), parsed); });
}

// From the end on, and by commas alone: what stands before may be made up, quotation marks that do not close included.
std::string Gate::clientOf(const std::string& from, std::string_view forwarded) const {
  std::string client = from;
  while (isTrusted(client) && !forwarded.empty()) {
    const size_t comma = forwarded.rfind(',');
    const std::string_view last = comma == std::string_view::npos ? forwarded : forwarded.substr(comma + 1);
    const std::string host(hostOf(withoutQuotes(trimmed(nodeOf(trimmed(last))))));
    if (isMadeUpName(host)) return host;
    boost::system::error_code error;
    const ip::address address = ip::make_address(host, error);
    if (error) break;
    client = addressText(address);
    forwarded = comma == std::string_view::npos ? std::string_view() : forwarded.substr(0, comma);
  }
  return client;
}

}  // namespace foreland::server
