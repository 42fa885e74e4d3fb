#include "lab/latency/section_chain.h"

#include "client/replica.h"
#include "oracle/reference/whole_mesh.h"
#include "server/section/sender.h"

namespace foreland::lab {

namespace {

class SectionChain {
 public:
  explicit SectionChain(std::shared_ptr<const server::World> world)
      : world_(std::move(world)), sender_(world_->hierarchy), replica_(server::welcomeTo(world_->hierarchy)) {}

  std::shared_ptr<const client::KeyframeMesh> at(const oracle::SectionRequest& wanted) {
    const proto::View view{wanted.pose, wanted.lens, wanted.tau_px, wanted.region_radius_m, wanted.region_angle_rad};
    message_.clear();
    time_ = time_ + Duration{1000};
    sender_.send(view, time_, scratch_, message_);
    CHECK_TRUE(replica_.apply(sender_.keyframe(), ByteSpan(message_).subspan(sender_.headerBytes())).ok());
    return std::make_shared<client::KeyframeMesh>(oracle::wholeMesh(replica_));
  }

 private:
  std::shared_ptr<const server::World> world_;
  server::SectionSender sender_;
  client::Replica replica_;
  server::SendScratch scratch_;
  Bytes message_;
  Time time_;
};

}  // namespace

oracle::SectionAt sectionChain(std::shared_ptr<const server::World> world) {
  const auto chain = std::make_shared<SectionChain>(std::move(world));
  return [chain](const oracle::SectionRequest& wanted) { return chain->at(wanted); };
}

}  // namespace foreland::lab
