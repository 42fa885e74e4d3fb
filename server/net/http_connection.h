// One socket that speaks HTTP until it closes or asks for WebSocket. Private to server/net; runs on the I/O thread.
#pragma once

#include <boost/asio/ip/tcp.hpp>

#include "server/net/context.h"

namespace foreland::server {

// Serves the requests of `socket`, and hands it to a ViewerConnection if one of them asks for WebSocket. Returns at
// once; the connection keeps itself alive until it is closed or handed over.
void serveHttp(boost::asio::ip::tcp::socket socket, Admission admission, ServerContext& context);

}  // namespace foreland::server
