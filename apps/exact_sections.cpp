#include "apps/exact_sections.h"

#include "client/replica.h"
#include "server/section/sender.h"
#include "server/session/world.h"

namespace foreland::apps {

namespace {

// Sends one keyframe to a new replica and takes its mesh, as a viewer would at its first keyframe.
class ExactSections {
 public:
  ExactSections(std::shared_ptr<const terrain::Scene> scene, server::SceneObjects objects)
      : scene_(std::move(scene)),
        hierarchy_(scene_, proto::ErrorBound::kSpheroid, std::move(objects)),
        welcome_(server::welcomeTo(hierarchy_)) {}

  std::shared_ptr<const client::KeyframeMesh> at(const oracle::SectionRequest& wanted) {
    const proto::View view{wanted.pose, wanted.lens, wanted.tau_px, wanted.region_radius_m, wanted.region_angle_rad};
    server::SectionSender sender(hierarchy_);
    if (const proto::Epochs& epochs = hierarchy_.epochs().epochs(); !epochs.empty())
      sender.showAt(epochs.clamp(static_cast<double>(wanted.scene_time.us)));
    Bytes message;
    sender.send(view, Time{}, scratch_, message);
    client::Replica replica(welcome_);
    CHECK_TRUE(replica.apply(sender.keyframe(), ByteSpan(message).subspan(sender.headerBytes())).ok());
    return std::make_shared<client::KeyframeMesh>(replica.buildMesh());
  }

 private:
  std::shared_ptr<const terrain::Scene> scene_;
  server::Hierarchy hierarchy_;
  proto::Welcome welcome_;
  server::SendScratch scratch_;
};

}  // namespace

oracle::SectionAt exactSections(std::shared_ptr<const terrain::Scene> scene, server::SceneObjects objects) {
  const auto sections = std::make_shared<ExactSections>(std::move(scene), std::move(objects));
  return [sections](const oracle::SectionRequest& wanted) { return sections->at(wanted); };
}

}  // namespace foreland::apps
