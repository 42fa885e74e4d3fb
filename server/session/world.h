// What all sessions of a server share: one immutable scene. Any thread.
#pragma once

#include <memory>

#include "proto/message/message.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

struct World {
  explicit World(std::shared_ptr<const terrain::Scene> scene, SceneObjects objects = {})
      : hierarchy(std::move(scene), proto::ErrorBound::kSpheroid, std::move(objects)) {}
  Hierarchy hierarchy;
};

// What a client is told about a scene; tolerance and keyframe interval are the session's to fill in.
proto::Welcome welcomeTo(const Hierarchy& hierarchy);

}  // namespace foreland::server
