// The newest mesh of a viewer that draws ahead, taken once, with the tiles that are laid over it. For a host that
// prepares meshes in one thread and draws them in another. One owner.
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "client/imagery/drape.h"
#include "client/viewer.h"

namespace foreland::client {

class NewestMesh {
 public:
  // `viewer` outlives it.
  explicit NewestMesh(Viewer& viewer) : viewer_(&viewer) {}

  // How many layers the texture arrays of relief and imagery have. Before the first mesh is taken.
  void setTextureLayers(const Drape::Sizes& layers) { layers_ = layers; }
  // The newest mesh's interval, and drape() advanced to it; nullptr if it has been taken already. The mesh is
  // Viewer::drawn().
  const Interval* take();
  // What was taken is lost: the newest mesh is taken again, and all tiles come again with it and those that follow.
  void redraw() { taken_ = draped_scene_ = 0; }
  // Towards the sun that casts shadows, in the scene's axes; nothing: none does.
  void setSun(const std::optional<glm::dvec3>& sun);

  // Once a mesh has been taken, until the host has another viewer.
  std::optional<Drape>& drape() { return drape_; }
  uint32_t drapedScene() const { return draped_scene_; }  // TileStore::scene() that it is for

 private:
  void enterScene();

  Viewer* viewer_;
  uint32_t taken_ = 0;  // version of the mesh
  Drape::Sizes layers_;
  std::optional<Drape> drape_;
  uint32_t draped_scene_ = 0;
  std::optional<glm::dvec3> sun_;
};

}  // namespace foreland::client
