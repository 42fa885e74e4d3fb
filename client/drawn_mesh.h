// The mesh that is drawn, brought from one interval to the next by the patches of the intervals between. Patches wait
// here until they are shown or skipped. One owner.
#pragma once

#include <deque>
#include <memory>

#include "client/mesh/patch/blend_patch.h"

namespace foreland::client {

class DrawnMesh {
 public:
  // `version` ascends. Each patch follows from the one before, unless it is whole.
  void add(uint32_t version, std::shared_ptr<const MeshPatch> patch);
  // Applies what leads to this version; there must have been a patch.
  void show(uint32_t version);
  // Applies what leads up to this version, but not to it: those before it will not be shown.
  void skipTo(uint32_t version);

  // Applies a patch at once; none waits.
  void apply(const MeshPatch& patch);

  const KeyframeMesh& mesh() const { return mesh_; }
  PatchedMesh& terrain() { return terrain_; }
  PatchedMesh& objects() { return objects_; }

 private:
  struct Waiting {
    uint32_t version;
    std::shared_ptr<const MeshPatch> patch;
  };
  KeyframeMesh mesh_;
  PatchedMesh terrain_{mesh_}, objects_{mesh_.objects};
  std::deque<Waiting> waiting_;
};

}  // namespace foreland::client
