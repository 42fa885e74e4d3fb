// What a client draws of a layer of tiles: which of them with which mesh, as the page's worker decides it, each decoded
// as soon as it is wanted. For flights in virtual time. One owner.
#pragma once

#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "client/imagery/drape.h"
#include "client/viewer.h"

namespace foreland::sim {

// Tiles as they are drawn in a frame, by key, and how far each has faded to its parent's image: 0 not at all, 1 whole.
using DrawnTiles = std::unordered_map<uint64_t, float>;

class ClientDrape {
 public:
  explicit ClientDrape(proto::TileContent content) : content_(content) {}

  // After each keyframe that the viewer has decoded.
  void onKeyframe(const client::Viewer& viewer);

  // What is shown at the end of the mesh that was drawn before and at the beginning of this one, if it is another.
  struct Handover {
    DrawnTiles before, after;
  };
  std::optional<Handover> handoverTo(uint32_t mesh_version);
  // Of a frame. Forgets the meshes before.
  DrawnTiles drawn(uint32_t mesh_version, float weight);
  // client::Drape::texelPx() of a mesh; infinity if there is none.
  double texelPx(uint32_t mesh_version) const;

 private:
  struct Mesh {
    std::vector<client::Residency::Shown> shown;
    double texel_px;
  };

  proto::TileContent content_;
  std::optional<client::Drape> drape_;
  std::map<uint32_t, Mesh> meshes_;  // by version
  uint32_t drawn_version_ = 0;
};

}  // namespace foreland::sim
