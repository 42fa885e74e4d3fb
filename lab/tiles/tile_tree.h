// A scene as CesiumJS would be served it: a quadtree of tiles of 65 x 65 samples, each level with half the distance
// between samples of the one above. The heights are the scene's own; tiles at the data's border are cut off there.
// One owner, because what is asked for is kept.
#pragma once

#include <array>
#include <compare>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <vector>

#include "base/result.h"
#include "client/mesh/patch/keyframe_mesh.h"
#include "lab/wire/peers/peer_mesh.h"
#include "proto/space/frame_grid.h"
#include "proto/space/pose.h"
#include "terrain/store/scene.h"

namespace foreland::lab {

struct TileId {
  uint32_t level = 0, x = 0, y = 0;  // level 0 is the one tile that covers all
  auto operator<=>(const TileId&) const = default;
  TileId parent() const { return {level - 1, x / 2, y / 2}; }
  bool isIn(const TileId& other) const;
};

// Quantized-mesh in gzip, or Draco on integers (lab/wire/peers).
enum class TileCodec : uint8_t { kQuantizedMesh, kDraco };

class TileTree {
 public:
  static constexpr uint32_t kCells = 64;  // a side

  explicit TileTree(std::shared_ptr<const terrain::Scene> scene);

  uint32_t finestLevel() const { return finest_; }
  // At most four.
  std::vector<TileId> children(const TileId& tile) const;

  // What CesiumJS takes for the error of a level: a quarter of the distance between its samples (metres).
  double geometricError(uint32_t level) const { return 0.25 * spacing_m_ * stride(level); }
  // Pixels: that error at the point of the tile's box that is nearest to the eye.
  double screenError(const TileId& tile, const proto::Pose& pose, const proto::Lens& lens);
  bool isInView(const TileId& tile, const proto::Pose& pose, const proto::Lens& lens);

  // Vertices in samples and quanta, relative to the tile's corner.
  PeerMesh mesh(const TileId& tile) const;
  // Of the coded tile, without what carries it. Milliseconds at the first call for a tile.
  Result<size_t> bytes(const TileId& tile, TileCodec codec);
  size_t triangles(const TileId& tile) const;

  // Height in quanta of the tile's surface at a sample in it.
  double heightAt(const TileId& tile, uint32_t x, uint32_t y) const;
  // The largest distance on the screen (pixels) by which a vertex of `fine`, a tile in `coarse`, moves if one takes the
  // other's place.
  double jump(const TileId& fine, const TileId& coarse, const proto::Pose& pose, const proto::Lens& lens) const;
  // What is drawn when these tiles are, as oracles take it.
  client::KeyframeMesh drawn(const std::vector<TileId>& tiles, const glm::dvec3& origin) const;

 private:
  // Of the tile's vertices, along east, north and up at its middle.
  struct TileBox {
    glm::dvec3 centre, half;
    std::array<glm::dvec3, 3> axes;
  };
  uint32_t stride(uint32_t level) const { return 1u << (finest_ - level); }
  // The samples of the tile's columns or rows.
  std::vector<uint32_t> lines(uint32_t index, uint32_t level, uint32_t last) const;
  double height(uint32_t x, uint32_t y) const { return scene_->height(proto::NodeId::at(x, y)); }
  const TileBox& box(const TileId& tile);

  std::shared_ptr<const terrain::Scene> scene_;
  proto::FrameGrid frame_;
  uint32_t last_x_, last_y_;  // samples
  uint32_t finest_ = 0;
  double spacing_m_ = 0;
  std::map<TileId, TileBox> boxes_;
  std::map<TileId, std::array<size_t, 2>> bytes_;  // by codec; 0: not asked for
};

}  // namespace foreland::lab
