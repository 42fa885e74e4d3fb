#include "server/net/access/listen_address.h"

#include <arpa/inet.h>

#include <charconv>
#include <optional>

namespace foreland::server {
namespace {

bool isAddress(const std::string& host) {
  unsigned char bytes[sizeof(in6_addr)];
  return inet_pton(AF_INET, host.c_str(), bytes) == 1 || inet_pton(AF_INET6, host.c_str(), bytes) == 1;
}

std::optional<uint16_t> parsePort(std::string_view text) {
  uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return port;
}

}  // namespace

Result<ListenAddress> parseListenAddress(std::string_view text, std::string_view flag) {
  const Error refusal{ErrorCode::kInvalidArgument,
                      std::string(flag) + ": cannot listen on '" + std::string(text) +
                          "': give an address and a port from 0 to 65535, such as 127.0.0.1:8080 or [::1]:8080"};
  const size_t colon = text.rfind(':');
  const auto port = parsePort(colon == std::string_view::npos ? text : text.substr(colon + 1));
  if (!port) return refusal;
  if (colon == std::string_view::npos) return ListenAddress{.port = *port};
  std::string host(text.substr(0, colon));
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  if (host == "localhost") host = "127.0.0.1";
  const bool is_v6 = host.find(':') != std::string::npos;
  if (!isAddress(host) || is_v6 != bracketed) return refusal;
  return ListenAddress{.host = host, .port = *port};
}

std::string toString(const ListenAddress& address) {
  const bool is_v6 = address.host.find(':') != std::string::npos;
  return (is_v6 ? "[" + address.host + "]" : address.host) + ":" + std::to_string(address.port);
}

}  // namespace foreland::server
