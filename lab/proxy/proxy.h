// A proxy that carries TCP connections over simulated links (link_stream.h), in real time: whatever is sent through it
// arrives as if latency, jitter, rate, queue, losses and stalls of a real link lay between. It has one or more doors,
// ports with a link each, and connects whoever comes to any of them to the same server. It looks at no byte, so it
// carries TLS as well.
//
// When an end closes its side, the other one learns of that behind all bytes that are on the way, as over a network;
// when a connection breaks on one side, both are dropped at once with what is on the way. One thread of its own. What
// the system buffers beside the simulated link is kept small where the system lets us, but is not zero.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "server/net/access/listen_address.h"
#include "server/sched/clock.h"
#include "sim/link_models.h"

namespace foreland::lab {

struct ProxyDoor {
  server::ListenAddress listen;
  sim::LinkPair links;
  uint64_t seed = 1;  // of the first connection's link up; that down has the next one, as in the virtual world
};

struct ProxyOptions {
  std::vector<ProxyDoor> doors;
  server::ListenAddress to;
  std::function<void(const std::string&)> log{};  // a line at a time, by the proxy's thread; may be empty
};

class Proxy {
 public:
  // Listens at each door and carries until stop(). `clock` runs at the pace of real time; links begin at its time now.
  // An Error names the address that cannot be listened on and --listen. Whether the server is there is found out for
  // each connection: who cannot be connected is closed.
  static Result<std::unique_ptr<Proxy>> open(ProxyOptions options, server::Clock clock);
  ~Proxy();
  Proxy(const Proxy&) = delete;
  Proxy& operator=(const Proxy&) = delete;

  uint16_t port(size_t door) const;
  // Carried now. Any thread.
  size_t connections() const;
  // Closes doors and connections and joins the thread. May be called again; by the owner's thread only.
  void stop();

 private:
  class Impl;
  explicit Proxy(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace foreland::lab
