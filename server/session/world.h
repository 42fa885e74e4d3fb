// What all sessions of a server share: one immutable scene. Any thread.
#pragma once

#include <memory>

#include "server/section/hierarchy.h"

namespace foreland::server {

struct World {
  explicit World(std::shared_ptr<const terrain::Scene> scene) : hierarchy(std::move(scene)) {}
  Hierarchy hierarchy;
};

}  // namespace foreland::server
