// Makes the page's files smaller once, at the start, so that no request waits for it. Pure; any thread.
#pragma once

#include <memory>
#include <string>

namespace foreland::server {

// What browsers call `br` and `gzip`. Null if it saves less than a tenth. Cost: about a second a megabyte.
std::shared_ptr<const std::string> compressBrotli(const std::string& text);
std::shared_ptr<const std::string> compressGzip(const std::string& text);

}  // namespace foreland::server
