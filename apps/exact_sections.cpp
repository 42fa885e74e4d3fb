#include "apps/exact_sections.h"

#include <glm/common.hpp>
#include <limits>

#include "client/replica.h"
#include "oracle/reference/mesh_builder.h"
#include "oracle/reference/whole_mesh.h"
#include "proto/message/compact.h"
#include "server/section/sender.h"
#include "server/session/world.h"

namespace foreland::apps {

namespace {

// Sends one keyframe to a new replica and takes its mesh, as a viewer would at its first keyframe.
class ExactSections {
 public:
  explicit ExactSections(std::shared_ptr<const server::Hierarchy> hierarchy)
      : hierarchy_(std::move(hierarchy)), welcome_(server::welcomeTo(*hierarchy_)) {}

  std::shared_ptr<const client::KeyframeMesh> at(const oracle::SectionRequest& wanted) {
    const bool is_still_terrain = hierarchy_->objects().set.size() == 0 && hierarchy_->epochs().epochs().empty();
    return is_still_terrain ? refined(wanted) : sent(wanted);
  }

  // Without what only a connection needs: a third of the time of sent().
  std::shared_ptr<const client::KeyframeMesh> refined(const oracle::SectionRequest& wanted) {
    proto::KeyframeHeader header;
    header.index = 1;
    header.pose = proto::asSentInHeader(wanted.pose);
    header.lens = wanted.lens;
    header.tau_px = static_cast<float>(wanted.tau_px);
    header.region_radius_m = proto::shortAtLeast(wanted.region_radius_m);
    header.region_angle_rad = proto::shortAtLeast(wanted.region_angle_rad);
    CHECK_TRUE(server::refine(*hierarchy_, proto::viewOf(header), std::numeric_limits<size_t>::max(), scratch_.refine,
                              scratch_.section));
    const terrain::Scene& scene = hierarchy_->scene();
    client::HeldNodes nodes(hierarchy_->grid(), {scene.cornerHeights(), scene.centreHeights()});
    for (const proto::Slot slot : scratch_.section.slots) nodes.records().make(slot) = scene.nodes()[slot];
    nodes.step({.added = scratch_.section.slots, .removed = {}});
    nodes.step({});
    auto mesh = std::make_shared<client::KeyframeMesh>();
    mesh->from = mesh->to = header;
    mesh->origin = glm::round(header.pose.eye);
    oracle::MeshBuilder(hierarchy_->domain(), nodes, {}, {}, *mesh).run();
    return mesh;
  }

  // Sends one keyframe to a new replica and takes its mesh, as a viewer would at its first keyframe.
  std::shared_ptr<const client::KeyframeMesh> sent(const oracle::SectionRequest& wanted) {
    const proto::View view{wanted.pose, wanted.lens, wanted.tau_px, wanted.region_radius_m, wanted.region_angle_rad};
    server::SectionSender sender(*hierarchy_);
    if (const proto::Epochs& epochs = hierarchy_->epochs().epochs(); !epochs.empty())
      sender.showAt(epochs.clamp(static_cast<double>(wanted.scene_time.us)));
    Bytes message;
    sender.send(view, Time{}, scratch_, message);
    client::Replica replica(welcome_);
    CHECK_TRUE(replica.apply(sender.keyframe(), ByteSpan(message).subspan(sender.headerBytes())).ok());
    return std::make_shared<client::KeyframeMesh>(oracle::wholeMesh(replica));
  }

 private:
  std::shared_ptr<const server::Hierarchy> hierarchy_;
  proto::Welcome welcome_;
  server::SendScratch scratch_;
};

}  // namespace

std::function<oracle::SectionAt()> exactSectionsOf(std::shared_ptr<const terrain::Scene> scene,
                                                   server::SceneObjects objects) {
  const auto hierarchy =
      std::make_shared<const server::Hierarchy>(std::move(scene), proto::ErrorBound::kSpheroid, std::move(objects));
  return [hierarchy]() -> oracle::SectionAt {
    const auto sections = std::make_shared<ExactSections>(hierarchy);
    return [sections](const oracle::SectionRequest& wanted) { return sections->at(wanted); };
  };
}

oracle::SectionAt exactSections(std::shared_ptr<const terrain::Scene> scene, server::SceneObjects objects) {
  return exactSectionsOf(std::move(scene), std::move(objects))();
}

}  // namespace foreland::apps
