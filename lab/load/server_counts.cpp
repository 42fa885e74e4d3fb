#include "lab/load/server_counts.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <cstdlib>

namespace foreland::lab {

namespace net = boost::asio;
using net::ip::tcp;

Result<ServerCounts> parseCounts(const std::string& page) {
  ServerCounts counts;
  const std::pair<const char*, double*> figures[] = {{"foreland_keyframes_total", &counts.keyframes},
                                                     {"foreland_late_keyframes_total", &counts.late_keyframes},
                                                     {"process_cpu_seconds_total", &counts.cpu_s}};
  for (const auto& [name, value] : figures) {
    const std::string begin = "\n" + std::string(name) + " ";
    const size_t at = page.find(begin);
    if (at == std::string::npos) return Error{ErrorCode::kMalformed, "the server's metrics lack " + std::string(name)};
    *value = std::strtod(page.c_str() + at + begin.size(), nullptr);
  }
  return counts;
}

Result<ServerCounts> readCounts(uint16_t port) {
  boost::system::error_code error;
  net::io_context io;
  tcp::socket socket(io);
  std::string page;
  socket.connect({net::ip::address_v4::loopback(), port}, error);
  const std::string request = "GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n";
  if (!error) net::write(socket, net::buffer(request), error);
  if (!error) net::read(socket, net::dynamic_buffer(page), error);
  if (error != net::error::eof) return Error{ErrorCode::kIo, "cannot read the server's metrics: " + error.message()};
  return parseCounts(page);
}

}  // namespace foreland::lab
