// A client at the end of a wire without a link: takes whole messages, which must be good. One owner.
#pragma once

#include "base/check.h"
#include "client/replica.h"
#include "server/session/world.h"

namespace foreland::lab {

class WireClient {
 public:
  explicit WireClient(const server::Hierarchy& hierarchy) : replica_(server::welcomeTo(hierarchy)) {}

  // A keyframe's message.
  void take(ByteSpan bytes) {
    const auto message = proto::decodeServerMessage(bytes, headers_);
    CHECK_TRUE(message.ok());
    const auto& keyframe = std::get<proto::KeyframeMessage>(*message);
    CHECK_TRUE(replica_.apply(keyframe.header, keyframe.delta).ok());
  }
  const client::Replica& replica() const { return replica_; }

 private:
  client::Replica replica_;
  proto::KeyframeMemory headers_;
};

}  // namespace foreland::lab
