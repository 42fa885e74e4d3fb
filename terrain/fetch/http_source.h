// Files in stores that speak HTTP and answer ranges: web servers and object stores. libcurl speaks it; its types stay
// in the source. Redirections are followed but where requests are signed, proxies are those of the environment, and
// certificates are checked.
#pragma once

#include <memory>

#include "base/result.h"
#include "terrain/fetch/store_address.h"
#include "terrain/store/distant/range_source.h"

namespace foreland::terrain {

// Blocks while it reads; a store that is silent for 10 seconds is given up. Errors name the file and the remedy. Any
// thread; a connection for each that reads, kept open.
std::shared_ptr<RangeSource> httpSource(const StoreAddress& address);

// A whole file, of at most so many bytes. Blocks likewise.
Result<Bytes> fetchWhole(const StoreAddress& address, uint64_t most_bytes);

}  // namespace foreland::terrain
