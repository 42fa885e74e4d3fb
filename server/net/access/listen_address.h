// Parses and prints the address to listen on. Pure; any thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"

namespace foreland::server {

struct ListenAddress {
  std::string host = "127.0.0.1";  // an IPv4 or IPv6 address without brackets
  uint16_t port = 8080;            // 0 for any free one
};

// Takes "127.0.0.1:8080", "[::1]:8080", "localhost:8080" or a port alone (on 127.0.0.1 then). Other names are an Error;
// nothing is looked up. It names `flag`, where the text stands.
Result<ListenAddress> parseListenAddress(std::string_view text, std::string_view flag = "--listen");

// "127.0.0.1:8080" or "[::1]:8080".
std::string toString(const ListenAddress& address);

}  // namespace foreland::server
