#include "apps/exact_sections.h"

#include "client/replica.h"
#include "proto/delta_codec.h"
#include "proto/message.h"
#include "server/section/held_nodes.h"
#include "server/section/hierarchy.h"
#include "server/section/refine.h"

namespace foreland::apps {

namespace {

proto::Welcome welcomeOf(const terrain::Scene& scene) {
  return {.scene_id = scene.id(),
          .title = {},
          .crs = {},
          .frame = scene.frame(),
          .shape = scene.grid().shape(),
          .lowest = scene.heightRange().lowest,
          .highest = scene.heightRange().highest,
          .corner_heights = {scene.cornerHeights().begin(), scene.cornerHeights().end()},
          .centre_heights = {scene.centreHeights().begin(), scene.centreHeights().end()},
          .keyframe_interval = {}};
}

// Refines from nothing and lets a replica make the mesh, as a viewer would on its first keyframe.
class ExactSections {
 public:
  explicit ExactSections(std::shared_ptr<const terrain::Scene> scene)
      : scene_(std::move(scene)), hierarchy_(scene_), welcome_(welcomeOf(*scene_)) {}

  std::shared_ptr<const client::KeyframeMesh> at(const bench::SectionRequest& wanted) {
    const server::View view{proto::asSent(wanted.pose), wanted.lens, wanted.tau_px, wanted.ball_m, wanted.turn_rad};
    // Bounded by the scene alone, so it always completes.
    CHECK_TRUE(server::refine(hierarchy_, view, scene_->grid().slotCount(), scratch_, section_));
    const proto::CutDelta delta{.added = section_.slots, .removed = {}};
    client::Replica replica(welcome_);
    proto::KeyframeHeader header;
    header.index = 1;
    header.pose = view.pose;
    header.tau_px = static_cast<float>(wanted.tau_px);
    header.fingerprint = proto::fingerprint(section_.slots);
    Bytes bytes;
    proto::DeltaModel model;
    proto::encodeDelta(scene_->grid(), hierarchy_.frame(), delta, proto::viewOf(header),
                       server::SectionNodes(section_, *scene_), model, bytes);
    CHECK_TRUE(replica.apply(header, bytes).ok());
    return std::make_shared<client::KeyframeMesh>(replica.buildMesh());
  }

 private:
  std::shared_ptr<const terrain::Scene> scene_;
  server::Hierarchy hierarchy_;
  proto::Welcome welcome_;
  server::RefineScratch scratch_;
  proto::Section section_;
};

}  // namespace

bench::SectionAt exactSections(std::shared_ptr<const terrain::Scene> scene) {
  const auto sections = std::make_shared<ExactSections>(std::move(scene));
  return [sections](const bench::SectionRequest& wanted) { return sections->at(wanted); };
}

}  // namespace foreland::apps
