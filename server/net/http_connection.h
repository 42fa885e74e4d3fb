// One socket that speaks HTTP, until it closes or asks for WebSocket. Private to server/net; on the I/O thread.
#pragma once

#include <boost/asio/ip/tcp.hpp>

#include "server/net/context.h"

namespace foreland::server {

// Serves requests, then hands the socket to a ViewerConnection if it is asked to; lives as long as it has something to
// do.
void serveHttp(boost::asio::ip::tcp::socket socket, ServerContext& context);

}  // namespace foreland::server
