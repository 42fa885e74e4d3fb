// A ray caster of all that a scene file holds. The terrain is a quad a cell, turned such that its diagonal is that of
// the finest section's two triangles, or a quad a flat square (flat_squares.h) where it is fine in places only; of
// globes it is the finest section's triangles themselves. Objects are instances of their models.
#include <algorithm>
#include <glm/common.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <vector>

#include "proto/space/frame_grid.h"
#include "proto/topology/mesh_triangles.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/render/full_ground.h"
#include "terrain/store/flat_squares.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;

constexpr uint64_t kMaxSamples = 1u << 28, kMaxSquares = 1u << 25;

// The corners of a cell, or of a square that has a corner at multiples of its side, such that its triangles are (0, 1,
// 3) and (2, 3, 1), counter-clockwise seen from above. The diagonal joins the corner whose coordinates are both even
// with the one where both are odd: it is the edge from the centre of a square of 2 x 2 cells to the square's corner.
std::array<NodeId, 4> cornersOf(uint32_t x, uint32_t y, uint32_t side = 1) {
  const NodeId sw = NodeId::at(x, y), se = NodeId::at(x + side, y), ne = NodeId::at(x + side, y + side),
               nw = NodeId::at(x, y + side);
  return (x / side + y / side) % 2 == 0 ? std::array{nw, sw, se, ne} : std::array{sw, se, ne, nw};
}

class FullTerrain final : public FullGround {
 public:
  FullTerrain(std::shared_ptr<const Scene> scene, const proto::EpochWeights& ground)
      : scene_(std::move(scene)),
        ground_(ground),
        columns_(scene_->grid().shape().samples_x),
        rows_(scene_->grid().shape().samples_y),
        frame_(scene_->frame(), columns_ - 1, rows_ - 1) {
    if (scene_->isSparse())
      FlatSquares(scene_->grid(), scene_->pages()).forEach([&](uint32_t x, uint32_t y, uint32_t side) {
        if (squares_.size() <= kMaxSquares) squares_.push_back({x, y, side});
      });
  }

  bool isTooLarge() const override { return squares_.size() > kMaxSquares; }
  glm::dvec3 middle() const { return position(NodeId::at(columns_ / 2, rows_ / 2)); }

  void addTo(EmbreeScene& embree, const glm::dvec3& origin) const override {
    if (!squares_.empty()) return addSquaresTo(embree, origin);
    const size_t cells = size_t{columns_ - 1} * (rows_ - 1);
    embree.addQuads(size_t{columns_} * rows_, cells, [&](std::span<glm::vec3> vertices, std::span<glm::uvec4> quads) {
      for (uint32_t y = 0, i = 0; y < rows_; ++y)
        for (uint32_t x = 0; x < columns_; ++x) vertices[i++] = glm::vec3(position(NodeId::at(x, y)) - origin);
      for (uint32_t y = 0, i = 0; y + 1 < rows_; ++y)
        for (uint32_t x = 0; x + 1 < columns_; ++x, ++i)
          for (int k = 0; k < 4; ++k) quads[i][k] = number(cornersOf(x, y)[static_cast<size_t>(k)]);
    });
  }

  std::array<TriangleCorner, 3> corners(const EmbreeHit& hit) const override {
    const std::array<NodeId, 4> cell = cellOf(hit.primitive);
    if (hit.is_second) return {corner(cell[2]), corner(cell[3]), corner(cell[1])};
    return {corner(cell[0]), corner(cell[1]), corner(cell[3])};
  }

 private:
  struct Square {
    uint32_t x, y, side;
  };

  std::array<NodeId, 4> cellOf(uint32_t primitive) const {
    if (squares_.empty()) return cornersOf(primitive % (columns_ - 1), primitive / (columns_ - 1));
    const Square& s = squares_[primitive];
    return cornersOf(s.x, s.y, s.side);
  }
  void addSquaresTo(EmbreeScene& embree, const glm::dvec3& origin) const {
    embree.addQuads(4 * squares_.size(), squares_.size(),
                    [&](std::span<glm::vec3> vertices, std::span<glm::uvec4> quads) {
                      for (uint32_t i = 0; i < squares_.size(); ++i) {
                        const std::array<NodeId, 4> corners = cellOf(i);
                        for (uint32_t k = 0; k < 4; ++k) {
                          vertices[4 * size_t{i} + k] = glm::vec3(position(corners[k]) - origin);
                          quads[i][static_cast<int>(k)] = 4 * i + k;
                        }
                      }
                    });
  }
  uint32_t number(NodeId v) const { return v.y() * columns_ + v.x(); }
  // Quanta.
  double height(NodeId v) const {
    double height = scene_->height(v);
    const EpochTable& table = scene_->epochs();
    for (uint32_t k = 0; k < (table.epochs().empty() ? 0 : ground_.count); ++k)
      if (const uint32_t epoch = ground_.epoch[k]; table.epochs().mayMove(epoch, v))
        height += ground_.weight[k] * table.offset(epoch, scene_->grid(), v);
    return height;
  }
  glm::dvec3 position(NodeId v) const { return frame_.position(v, height(v)); }
  TriangleCorner corner(NodeId v) const {
    const double height = this->height(v);
    return {frame_.position(v, height), {v.x(), v.y()}, height * scene_->frame().height_quantum_m};
  }

  std::shared_ptr<const Scene> scene_;
  proto::EpochWeights ground_;
  uint32_t columns_, rows_;
  proto::FrameGrid frame_;
  std::vector<Square> squares_;  // of scenes that are fine in places only
};

// A model's every triangle, in its own frame, mixed from its poses. Vertices are numbered base vertices first, then
// nodes by slot.
class FullModel {
 public:
  // `poses` are the weights of all poses but the first.
  FullModel(std::shared_ptr<const MappedSurface> surface, std::vector<double> poses, const EmbreeScene& whole)
      : surface_(std::move(surface)), poses_(std::move(poses)), embree_(EmbreeScene::partOf(whole)) {
    const auto everywhere = [](NodeId) { return true; };
    const proto::MeshTopology& mesh = surface_->topology();
    for (uint32_t face = 0; face < mesh.base().faceCount(); ++face) {
      proto::forEachTriangleOf(mesh, face, everywhere, [&](NodeId a, NodeId b, NodeId c) {
        for (NodeId v : {a, b, c}) indices_.push_back(number(v));
      });
      face_end_.push_back(static_cast<uint32_t>(indices_.size() / 3));
    }
  }

  Status commit() {
    std::vector<glm::vec3> vertices;
    const size_t count = surface_->basePositions().size();
    for (size_t v = 0; v < count; ++v) vertices.emplace_back(basePosition(v));
    for (size_t slot = 0; slot < surface_->nodes().size(); ++slot) vertices.emplace_back(nodePosition(slot));
    embree_.addTriangles(vertices, indices_);
    return embree_.commit();
  }
  const EmbreeScene& embree() const { return embree_; }

  TriangleCorner corner(uint32_t triangle, size_t i) const {
    const proto::MeshTopology& mesh = surface_->topology();
    const uint32_t v = indices_[3 * size_t{triangle} + i], nodes = v - mesh.baseVertexCount();
    const NodeId id = v < mesh.baseVertexCount() ? proto::baseVertexId(v) : mesh.node(nodes);
    return {mesh.isBase(id) ? basePosition(proto::baseVertexOf(id)) : nodePosition(mesh.slot(id)),
            textureCoordinates(triangle, id), 0};
  }

 private:
  glm::dvec3 basePosition(size_t v) const { return position(surface_->basePositions()[v], surface_->baseMoves(), v); }
  glm::dvec3 nodePosition(size_t slot) const {
    return position(surface_->nodes()[slot].position, surface_->nodeMoves(), slot);
  }
  glm::dvec3 position(const glm::ivec3& first, std::span<const glm::ivec3> moves, size_t i) const {
    if (poses_.empty()) return glm::dvec3(first) * surface_->quantumMetres();
    const size_t each = surface_->movesEach();
    return proto::posed(first, moves.subspan(i * each, each), poses_) * surface_->quantumMetres();
  }
  uint32_t number(NodeId v) const {
    const proto::MeshTopology& mesh = surface_->topology();
    return mesh.isBase(v) ? proto::baseVertexOf(v) : mesh.baseVertexCount() + mesh.slot(v);
  }
  glm::dvec2 textureCoordinates(uint32_t triangle, NodeId v) const {
    const proto::AtlasLayout atlas = surface_->atlas();
    if (atlas.side == 0) return {0, 0};
    const proto::MeshTopology& mesh = surface_->topology();
    const auto face =
        static_cast<uint32_t>(std::upper_bound(face_end_.begin(), face_end_.end(), triangle) - face_end_.begin());
    const proto::FacePoint at = mesh.facePointIn(face, v);
    const double scale = mesh.weightScale();
    return atlas.coordinates(face, {at.weights[0] / scale, at.weights[1] / scale, at.weights[2] / scale});
  }

  std::shared_ptr<const MappedSurface> surface_;
  std::vector<double> poses_;
  std::vector<uint32_t> indices_, face_end_;  // triangles of the faces up to each
  EmbreeScene embree_;
};

// Geometry 0 is the terrain, geometry 1 + i object i.
class FullTriangles final : public TriangleSource {
 public:
  FullTriangles(std::unique_ptr<const FullGround> terrain, const proto::EpochWeights& ground, PlacedObjects objects)
      : terrain_(std::move(terrain)), ground_(ground), objects_(std::move(objects)) {
    for (const proto::ObjectPlacement& p : objects_.set.placements()) {
      placements_.push_back(p);
      if (!p.rise.isStill()) placements_.back().position += p.rise.at(ground_);
    }
  }

  Status addTo(EmbreeScene& embree, const glm::dvec3& origin) {
    terrain_->addTo(embree, origin);
    for (size_t i = 0; i < objects_.models.size(); ++i) {
      models_.push_back(
          std::make_unique<FullModel>(objects_.models[i], objects_.set.posesOfModel(i).weightsAt(ground_), embree));
      if (Status s = models_.back()->commit(); !s.ok()) return s;
    }
    for (const proto::ObjectPlacement& p : placements_) {
      const glm::dmat3 turn = glm::mat3_cast(p.orientation);
      embree.addInstance(models_[p.model]->embree(), glm::mat3(turn * p.scale), glm::vec3(p.position - origin));
    }
    return {};
  }

  std::array<TriangleCorner, 3> corners(const EmbreeHit& hit) const override {
    if (hit.instance == EmbreeHit::kNone) return terrain_->corners(hit);
    const proto::ObjectPlacement& placement = placements_[static_cast<size_t>(object(hit))];
    std::array<TriangleCorner, 3> corners;
    for (size_t i = 0; i < 3; ++i) {
      corners[i] = models_[placement.model]->corner(hit.primitive, i);
      corners[i].position = placement.toScene(corners[i].position);
    }
    return corners;
  }
  int32_t object(const EmbreeHit& hit) const override {
    return hit.instance == EmbreeHit::kNone ? RayHit::kTerrain : static_cast<int32_t>(hit.instance - 1);
  }

 private:
  std::unique_ptr<const FullGround> terrain_;
  proto::EpochWeights ground_;
  PlacedObjects objects_;
  std::vector<proto::ObjectPlacement> placements_;  // carried by the ground
  std::vector<std::unique_ptr<FullModel>> models_;
};

// Rays on the ground and what stands on it; in `ground` of the scene's time, relative to an origin.
Result<std::unique_ptr<const RayCaster::Impl>> castable(std::unique_ptr<const FullGround> terrain,
                                                        const std::shared_ptr<const Scene>& scene,
                                                        const proto::EpochWeights& ground, const glm::dvec3& origin) {
  if (terrain->isTooLarge())
    return Error{ErrorCode::kLimit,
                 "ray casting: the scene has more than 2^25 squares of ground, or 2^26 triangles, which are the most"};
  Result<PlacedObjects> objects = readObjects(scene);
  if (!objects.ok()) return objects.error();
  auto triangles = std::make_unique<FullTriangles>(std::move(terrain), ground, std::move(*objects));
  auto impl = std::make_unique<RayCaster::Impl>();
  impl->origin = origin;
  if (Status s = triangles->addTo(impl->embree, origin); !s.ok()) return s.error();
  if (Status s = impl->embree.commit(); !s.ok()) return s.error();
  impl->triangles = std::move(triangles);
  return std::unique_ptr<const RayCaster::Impl>(std::move(impl));
}

}  // namespace

Result<RayCaster> RayCaster::ofScene(std::shared_ptr<const Scene> scene, Time scene_time) {
  const proto::GridShape& shape = scene->grid().shape();
  // Floats about one origin are half a metre apart as far from it as a planet's radius.
  if (shape.is_cube)
    return Error{ErrorCode::kUnsupported,
                 "ray casting: the scene is a globe, of which rays are cast from one place at a time alone"};
  if (!scene->isSparse() && uint64_t{shape.samples_x} * shape.samples_y > kMaxSamples)
    return Error{ErrorCode::kLimit, "ray casting: the scene has " + std::to_string(shape.samples_x) + " x " +
                                        std::to_string(shape.samples_y) + " samples, 2^28 are the most"};
  const proto::Epochs& epochs = scene->epochs().epochs();
  const proto::EpochWeights ground = epochs.empty() ? proto::EpochWeights{} : epochs.weightsAt(scene_time);
  auto terrain = std::make_unique<FullTerrain>(scene, ground);
  const glm::dvec3 origin = glm::round(terrain->middle());
  auto impl = castable(std::move(terrain), scene, ground, origin);
  if (!impl.ok()) return impl.error();
  return RayCaster(std::move(*impl));
}

Result<RayCaster> RayCaster::ofGlobe(std::shared_ptr<const Scene> scene, const glm::dvec3& eye) {
  CHECK_TRUE(scene->grid().isCube());
  auto impl = castable(fullGlobe(scene, eye), scene, {}, eye);
  if (!impl.ok()) return impl.error();
  return RayCaster(std::move(*impl));
}

}  // namespace foreland::terrain
