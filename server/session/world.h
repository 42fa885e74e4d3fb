// What all sessions of a server share: one immutable scene. Any thread.
#pragma once

#include <memory>

#include "proto/message/message.h"
#include "server/occlusion/viewer_occlusion.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

struct World {
  explicit World(std::shared_ptr<const terrain::Scene> scene, SceneObjects objects = {})
      : hierarchy(std::move(scene), proto::ErrorBound::kSpheroid, std::move(objects)) {}
  Hierarchy hierarchy;
  std::shared_ptr<const SceneOcclusion> occlusion;  // of the hierarchy; null: nothing is left out as hidden
};

// The message that tells a client about a scene. The session fills in tolerance and keyframe interval.
proto::Welcome welcomeTo(const Hierarchy& hierarchy);

}  // namespace foreland::server
