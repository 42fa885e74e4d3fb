// The truth oracle of globes: judges what is drawn of one at every vertex of the scene, as oracle.h does. Where
// vertices are comes from vectors, angles and GeographicLib (cube_faces.h), their heights from the scene; it shares no
// code with the engine's topology, positions and horizon.
//
// The vertices are judged in patches: one for each face, of the levels that are whole, and one for each block of pages
// of each sparse level. A patch is the lattice of an Oracle, in whose places triangles are laid before it is asked. Of
// what lies behind the body, by the ellipsoid that no ground reaches into, only errors within the tolerance are looked
// at: nobody sees it.
//
// One owner. Cost: that of the oracles of all patches that the camera may see; each holds its vertices' positions, 32
// bytes a sample.
#pragma once

#include <memory>
#include <vector>

#include "oracle/oracle.h"
#include "terrain/store/scene.h"

namespace foreland::oracle {

class GlobeOracle {
 public:
  explicit GlobeOracle(std::shared_ptr<const terrain::Scene> scene);
  ~GlobeOracle();
  GlobeOracle(GlobeOracle&&) noexcept;

  GlobeOracle twin();
  // Beside the horizon's.
  void setSight(const Sight& sight);
  Deviation error(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose, const proto::Lens& lens);

 private:
  struct Patch;
  struct Shared;
  explicit GlobeOracle(std::shared_ptr<const Shared> shared, std::vector<Patch> patches);

  std::shared_ptr<const Shared> shared_;
  std::vector<Patch> patches_;
};

}  // namespace foreland::oracle
