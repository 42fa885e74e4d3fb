// The vertices of a terrain mesh that changes: where each is in the mesh's arrays, how it hangs together with others,
// and its state at the mesh's newest end. A vertex keeps its place while it is drawn; free places are taken again, the
// one that became free last first. One owner.
//
// Around a vertex lies a diamond: the two endpoints of the edge that it halves and the apexes of the triangles beside
// that edge. Its corners are numbered counter-clockwise. A vertex on a side of a square (grid.h) has them east, north,
// west and south of it; a square's centre north-east, north-west, south-west and south-east. Triangle q of a vertex has
// the corners q and q + 1 and the vertex itself, which is its apex, so every triangle of the hierarchy is known by its
// apex and q. A triangle is a leaf of the mesh or halved by a child of its apex.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "client/mesh/patch/complete_normals.h"
#include "client/mesh/patch/free_places.h"
#include "client/mesh/terrain/ground_point.h"
#include "proto/section/index_table.h"
#include "proto/topology/grid.h"

namespace foreland::client {

// What a triangle of the hierarchy is: a leaf, whose triangle of the mesh has a place; a leaf that the data's border
// cuts (border_cuts.h); halved by a child; or none, beyond the roots.
struct Link {
  enum class Kind : uint32_t { kNone = 0, kTriangle = 1u << 30, kCut = 2u << 30, kChild = 3u << 30 };

  uint32_t bits = 0;

  static Link of(Kind kind, uint32_t index) { return {static_cast<uint32_t>(kind) | index}; }
  Kind kind() const { return static_cast<Kind>(bits & (3u << 30)); }
  uint32_t index() const { return bits & ~(3u << 30); }
};

struct alignas(64) TerrainVertex {
  // In the scene's frame. The sum of face normals if the vertex belongs to the newest end's section, else a unit
  // vector.
  glm::dvec3 position{0};
  glm::dvec3 normal{0};
  proto::NodeId id;  // not of vertices on the border's cuts
  uint32_t packed_normal = 0;
  bool is_in_section = false;  // of the newest end
  bool is_true = false;        // its position is the node's own
  bool is_beyond = false;      // beyond the data
  uint8_t first_apex = 0;      // its diamond's corners first_apex and first_apex + 2 are apexes, the others endpoints

  std::array<uint32_t, 4> ring{kNoVertex, kNoVertex, kNoVertex, kNoVertex};
  std::array<Link, 4> links{};
  double height_m = 0, moved_m = 0;
  // The vertex's entries in the patch that is being made; kNoVertex if it has none.
  uint32_t position_entry = kNoVertex, normal_entry = kNoVertex;
  bool is_moving = false;  // scratch
  bool is_used = false;    // not a free place

  GroundPoint point() const { return {position, height_m, moved_m}; }
  void moveTo(const GroundPoint& p) { position = p.position, height_m = p.height_m, moved_m = p.moved_m; }
  glm::dvec3 unitNormal() const { return is_in_section ? client::unitNormal(normal) : normal; }
  std::array<uint32_t, 2> endpoints() const { return {ring[(first_apex + 1) % 4], ring[(first_apex + 3) % 4]}; }
};
static_assert(sizeof(TerrainVertex) == 128);

// Begins to load what will be read soon, where the machine can be told.
inline void fetch(const void* what) { __builtin_prefetch(what); }

class TerrainVertices {
 public:
  TerrainVertex& operator[](uint32_t place) { return all_[place]; }
  const TerrainVertex& operator[](uint32_t place) const { return all_[place]; }

  // Begins to load a vertex that will be needed soon: all of it, or only its state at the newest end.
  void fetch(uint32_t place) const {
    client::fetch(&all_[place]);
    client::fetch(&all_[place].ring);
  }
  void fetchState(uint32_t place) const { client::fetch(&all_[place]); }
  // Takes a free place.
  uint32_t add() {
    const uint32_t place = takePlace(all_, free_);
    all_[place] = {};
    all_[place].is_used = true;
    return place;
  }
  void remove(uint32_t place) {
    all_[place].is_used = false;
    free_.push_back(place);
  }
  // One past the largest place; how many are in use.
  uint32_t count() const { return static_cast<uint32_t>(all_.size()); }
  uint32_t used() const { return count() - static_cast<uint32_t>(free_.size()); }

  // The place of a node, kNoVertex if it has none.
  uint32_t find(proto::Slot slot) const { return blocks_[numbers_.find(slot / kBlock)].places[slot % kBlock]; }
  // The node must have no place.
  void insert(proto::Slot slot, uint32_t place) {
    uint32_t number = numbers_.find(slot / kBlock);
    if (number == proto::IndexTable::kNone) numbers_.insert(slot / kBlock, number = takePlace(blocks_, free_blocks_));
    blocks_[number].places[slot % kBlock] = place;
    ++blocks_[number].used;
  }
  // The node must have a place.
  void erase(proto::Slot slot) {
    const uint32_t number = numbers_.find(slot / kBlock);
    blocks_[number].places[slot % kBlock] = kNoVertex;
    if (--blocks_[number].used > 0) return;
    numbers_.erase(slot / kBlock);
    free_blocks_.push_back(number);
  }
  size_t bytes() const {
    return all_.capacity() * sizeof(TerrainVertex) + blocks_.capacity() * sizeof(Block) + numbers_.bytes() +
           (free_.capacity() + free_blocks_.capacity()) * sizeof(uint32_t);
  }

 private:
  static constexpr proto::Slot kBlock = 64;
  // The places of some slots that follow one another. That of IndexTable::kNone has none.
  struct Block {
    Block() { places.fill(kNoVertex); }
    std::array<uint32_t, kBlock> places;
    uint32_t used = 0;
  };

  std::vector<TerrainVertex> all_;
  std::vector<uint32_t> free_;
  proto::IndexTable numbers_;  // of blocks, by slot / kBlock
  std::vector<Block> blocks_ = std::vector<Block>(1);
  std::vector<uint32_t> free_blocks_;
};

}  // namespace foreland::client
