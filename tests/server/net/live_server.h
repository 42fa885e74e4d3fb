// A server in the test's own process, and viewers that fly at it over real sockets.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "client/viewer.h"
#include "proto/message/message.h"
#include "server/net/server.h"
#include "server/net/steady_clock.h"
#include "tests/server/net/client.h"
#include "tests/support/scene.h"

namespace foreland::test {

using server::ServeOptions;
using server::Server;
using server::steadyNow;

inline std::shared_ptr<const server::World> hillWorld() {
  static const auto world = std::make_shared<const server::World>(makeScene(129, 129, 7));
  return world;
}

inline ServeOptions testOptions() {
  ServeOptions options;
  options.listen.port = 0;
  options.session.keyframe_interval = Duration::milliseconds(20);
  return options;
}

inline std::unique_ptr<Server> serve(const ServeOptions& options,
                                     std::shared_ptr<const server::World> world = hillWorld()) {
  auto listening = Server::listen(std::move(world), options, steadyNow);
  EXPECT_TRUE(listening.ok()) << (listening.ok() ? "" : listening.error().message);
  return listening.ok() ? std::move(*listening) : nullptr;
}

inline proto::ViewRequest requestView() {
  proto::ViewRequest request;
  request.keyframe_interval = Duration::milliseconds(20);
  return request;
}

// Of which a view at all detail is more than the buffers of both systems hold.
inline std::shared_ptr<const server::World> roughWorld() {
  return std::make_shared<const server::World>(makeScene(257, 257, noise(3, 500)));
}

inline proto::ViewRequest requestAll() {
  proto::ViewRequest request = requestView();
  request.tau_px = 0.01;
  return request;
}

inline proto::Pose poseAt(Time now) {
  proto::Pose pose;
  pose.eye = {100 * std::sin(now.toSeconds()), 50, 1500};
  pose.orientation = proto::lookAlong({0.3, 0.6, -0.7}, {0, 0, 1});
  return pose;
}

// A real client over a real socket.
class LiveViewer {
 public:
  explicit LiveViewer(uint16_t port, const proto::ViewRequest& request = requestView(),
                      const std::string& path = "/fly")
      : socket_(port, 0, path), viewer_(request, client::Blend::kKeyframe, Duration::milliseconds(10)) {
    viewer_.leaveMeshesEmpty();
  }

  // Sends what is due, then takes what comes within a few milliseconds. False when the server has closed.
  bool advance() { return advance(poseAt(steadyNow())); }
  bool advance(const proto::Pose& pose) {
    viewer_.frame(steadyNow(), pose);
    for (Bytes message; viewer_.takeOutgoing(message);) socket_.send(message);
    if (!socket_.socket().isReadable(std::chrono::milliseconds(5))) return true;
    const auto message = socket_.receive();
    if (!message || message->opcode == Opcode::kClose) {
      close_code_ = message ? message->closeCode() : 0;
      return false;
    }
    const Status status = viewer_.receive(message->bytes(), steadyNow());
    EXPECT_TRUE(status.ok()) << status.error().message;
    return status.ok();
  }
  uint32_t keyframes() const { return viewer_.statistics().keyframes; }
  const client::Viewer& viewer() const { return viewer_; }
  WebSocketClient& socket() { return socket_; }
  int closeCode() const { return close_code_; }

 private:
  WebSocketClient socket_;
  int close_code_ = 0;
  client::Viewer viewer_;
};

}  // namespace foreland::test
