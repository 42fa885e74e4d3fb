// The server's certificate and key. Private to server/net.
#pragma once

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <memory>

#include "base/result.h"

namespace foreland::server {

// TLS 1.2 or newer. An Error names the file that cannot be used. Any thread.
Result<std::shared_ptr<boost::asio::ssl::context>> loadTls(const std::filesystem::path& certificate,
                                                           const std::filesystem::path& key);

}  // namespace foreland::server
