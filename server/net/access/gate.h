// Who may connect as a viewer: from which pages, with which token, through which proxies. Values and texts only; the
// sockets are elsewhere. I/O thread, which owns what is counted.
#pragma once

#include <boost/asio/ip/address.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/result.h"
#include "server/net/access/token.h"
#include "server/net/metrics/metrics.h"

namespace foreland::server {

// An address as it is written and compared here: that of IPv4 which IPv6 has mapped (::ffff:192.0.2.1) as IPv4.
std::string addressText(const boost::asio::ip::address& address);
// Of whom connections are counted together: an address of IPv4, or the network of 64 bits that a provider gives to one
// customer of IPv6. The text itself if it is no address.
std::string networkOf(const std::string& address);

struct GateOptions {
  std::vector<std::string> allowed_origins{};  // beside the server's own; empty: any
  std::string token_secret{};                  // empty: no token is asked for
  std::vector<std::string> trusted_proxies{};  // addresses, or networks such as 10.0.0.0/8
};

// An Error names the flag and the value that will not do.
Status check(const GateOptions& options);

// What the request of a viewer says of itself.
struct Visitor {
  std::string_view origin{}, host{}, target{}, authorization{};  // empty if absent
};

struct Rejection {
  unsigned status = 403;
  RefusedFor reason = RefusedFor::kOrigin;
  std::string why;
};

// A viewer's pass, which counts for its token as long as it lives. Without tokens it is empty.
struct Pass {
  Token token;
  std::shared_ptr<size_t> viewers{};  // of that name; its use count, less the gate's own, is how many there are
};

class Gate {
 public:
  explicit Gate(GateOptions options) : options_(std::move(options)) {}

  std::variant<Pass, Rejection> admit(const Visitor& visitor, int64_t now_s);

  // The origin with whose pages files are shared that a page of `origin` asks for: "*" if with any, else that origin if
  // it may connect, else none.
  std::string sharesWith(std::string_view origin) const;
  bool isTrusted(const std::string& address) const;
  // Whose request this is, by the list that trusted proxies have added to, of X-Forwarded-For or of Forwarded (RFC
  // 7239): the last one that is none of theirs, an address without its port, or a name that a proxy has made up for one
  // (`_name`); `from` if there is none.
  std::string clientOf(const std::string& from, std::string_view forwarded) const;

 private:
  bool isAllowed(const Visitor& visitor) const;

  GateOptions options_;
  std::map<std::string, std::weak_ptr<size_t>> viewers_;  // by the tokens' names
};

}  // namespace foreland::server
