// Judges ground of which most places of the lattice hold nothing, and ground of several lattices that are glued: patch
// by patch, each an Oracle on a lattice of its own, in whose places triangles are laid before it is asked.
//
// Judged is every vertex that the scene has, at the step of its own level. Between them its ground and all that is
// drawn of it are even on the triangles of the finest mesh, so that no point of the ground is further off, in metres,
// than the vertices around it. What is drawn over no vertex at all is for the crack checker.
//
// One owner. Memory: bounds of 32 x 32 places, 88 bytes each, and of places that a frame needs at most kMostHeld blocks
// beside those of one patch, 32 KB each. Cost: that of the oracles of all patches, and of reading again what did not
// fit.
#pragma once

#include <array>
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <vector>

#include "oracle/oracle.h"
#include "terrain/store/scene.h"

namespace foreland::oracle {

using Place = glm::vec<2, int64_t>;

// A lattice of its own on a face: places first + step * (x, y), of which those count that are vertices of some levels.
struct PatchLattice {
  uint32_t face = 0;
  Place first{0, 0};
  int64_t step = 1;
  glm::uvec2 size{2, 2};
  bool has_coarser = false;  // whether vertices of coarser levels than the step's count, too

  Place at(uint32_t x, uint32_t y) const { return first + step * Place(x, y); }
  // Whether a place of it is a vertex of a coarser level than the step's.
  bool isCoarser(const Place& place) const { return ((place.x | place.y) & (2 * step - 1)) == 0; }
};

// One of the levels that are whole, for each face, and one for each square of 32 x 32 pages of each sparse level.
std::vector<PatchLattice> patchesOf(const terrain::Scene& scene);

// A triangle of a mesh on a face.
struct FaceTriangle {
  uint32_t face = 0;
  std::array<uint32_t, 3> vertex;
  std::array<glm::dvec2, 3> place;
};

// What patches are made of, and how a mesh and they go together. All threads share it.
struct PatchworkTruth {
  std::vector<PatchLattice> patches;
  std::function<Truth(const PatchLattice&)> of;
  std::function<std::vector<FaceTriangle>(const client::KeyframeMesh&)> triangles;
  std::function<glm::uvec2(const PatchLattice&, const Place&)> sample;                // by which a place is named
  std::function<bool(const glm::dvec3& point, const glm::dvec3& eye)> may_be_seen{};  // empty: all
};

class Patchwork {
 public:
  static constexpr size_t kMostHeld = 4096;  // blocks

  explicit Patchwork(PatchworkTruth truth);
  ~Patchwork();
  Patchwork(Patchwork&&) noexcept;

  Patchwork twin();
  // Beside what may not be seen anyhow.
  void setSight(const Sight& sight);
  void showAt(const TruthTime& time);

  // As of an Oracle.
  Deviation error(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose, const proto::Lens& lens);
  Deviation difference(Surface a, Surface b, const proto::Pose& pose, const proto::Lens& lens);
  std::span<const double> sharesShown() const;
  std::span<const Time> epochs() const;

 private:
  struct Patch {
    PatchLattice lattice;
    Oracle oracle;
  };
  Patchwork(std::shared_ptr<const PatchworkTruth> truth, std::vector<Patch> patches);
  Deviation compare(std::span<const Surface> surfaces, SurfacePair pair, const proto::Pose& pose,
                    const proto::Lens& lens);

  std::shared_ptr<const PatchworkTruth> truth_;
  std::vector<Patch> patches_;
};

}  // namespace foreland::oracle
