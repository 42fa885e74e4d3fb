// Both ends of one viewer's stream without a link between them: the server sends keyframes, with or without what ridges
// hide, and the client takes each before the next one is sent. One owner.
#pragma once

#include "base/check.h"
#include "client/replica.h"
#include "server/section/sender.h"
#include "server/session/world.h"

namespace foreland::lab {

class ViewerStream {
 public:
  // Nothing is left out as hidden if `visibility` is null; otherwise the connection tells hidden blocks. All must
  // outlive the stream.
  ViewerStream(const server::Hierarchy& hierarchy, proto::BlockVisibility* visibility,
               server::ObjectVisibility* object_visibility = nullptr)
      : visibility_(visibility),
        object_visibility_(object_visibility),
        sender_(hierarchy),
        replica_(welcomeOf(hierarchy, visibility)) {
    if (visibility) sender_.signalBlocks();
  }

  void send(const proto::View& view, Time time) {
    message_.clear();
    sender_.send(view, time, scratch_, message_, visibility_, object_visibility_);
  }
  // The message of the last send().
  void take() {
    const auto message = proto::decodeServerMessage(message_, headers_);
    CHECK_TRUE(message.ok());
    const auto& keyframe = std::get<proto::KeyframeMessage>(*message);
    CHECK_TRUE(replica_.apply(keyframe.header, keyframe.delta).ok());
  }

  const server::SectionSender& sender() const { return sender_; }
  const client::Replica& replica() const { return replica_; }
  size_t messageBytes() const { return message_.size(); }
  size_t added() const { return scratch_.delta.added.size(); }  // nodes of the terrain, by the last send()

 private:
  static proto::Welcome welcomeOf(const server::Hierarchy& hierarchy, const proto::BlockVisibility* visibility) {
    proto::Welcome welcome = server::welcomeTo(hierarchy);
    welcome.occlusion = visibility != nullptr;
    return welcome;
  }

  proto::BlockVisibility* visibility_;
  server::ObjectVisibility* object_visibility_;
  server::SectionSender sender_;
  server::SendScratch scratch_;
  Bytes message_;
  client::Replica replica_;
  proto::KeyframeMemory headers_;
};

}  // namespace foreland::lab
