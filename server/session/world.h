// What all sessions of a server share: one immutable scene. Any thread.
#pragma once

#include <memory>

#include "proto/message.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

struct World {
  explicit World(std::shared_ptr<const terrain::Scene> scene) : hierarchy(std::move(scene)) {}
  Hierarchy hierarchy;
};

// What a client is told about a scene; tolerance and keyframe interval are the session's to fill in.
proto::Welcome welcomeTo(const terrain::Scene& scene);

}  // namespace foreland::server
