// The terrain's mesh at the data's border: it is the mesh of the whole roots, cut off, for any sections and heights.
#include "oracle/reference/mesh_builder.h"

#include <gtest/gtest.h>

#include <optional>
#include <set>
#include <utility>

#include "base/rng.h"

namespace foreland::oracle {
namespace {

using client::EndHeights;
using client::HeldNodes;
using client::KeyframeMesh;
using proto::NodeId;
using proto::Slot;

constexpr double kRounding_m = 1e-3;  // positions of meshes are floats, less than a kilometre from their origin

proto::Frame frameOf(proto::FrameKind kind) {
  proto::Frame frame;
  frame.kind = kind;
  frame.axis_x_m = {10, 2};
  frame.axis_y_m = {-2, 10};
  if (kind == proto::FrameKind::kPlanar) return frame;
  frame.latitude0_rad = 0.8;
  frame.longitude0_rad = 0.1;
  frame.latitude_step_rad = frame.longitude_step_rad = 1.5e-6;
  frame.origin = {0.8, 0.1, 0};
  return frame;
}

// The same nodes, once on grids whose data fills the roots, and once on grids whose data ends within them.
class MeshAtTheBorder : public testing::Test {
 protected:
  static constexpr uint32_t kRoots = 2, kRootLog2 = 4, kSide = (kRoots << kRootLog2) + 1;

  static proto::TerrainDomain domainOf(uint32_t samples_x, uint32_t samples_y, proto::FrameKind kind) {
    return {proto::GridTopology::create({kRoots, kRoots, kRootLog2, samples_x, samples_y}).value(), frameOf(kind)};
  }

  // Draws two parent-closed sets of nodes, and heights.
  void drawSections(const proto::GridTopology& grid) {
    for (auto* base : {&corners_, &centres_})
      for (int32_t& height : *base) height = static_cast<int32_t>(rng_.below(2000));
    heights_.assign(grid.slotCount(), 0);
    for (int32_t& height : heights_) height = static_cast<int32_t>(rng_.below(2000));
    for (std::set<Slot>* section : {&from_, &to_}) {
      section->clear();
      for (uint64_t i = 20 + rng_.below(60); i > 0; --i)
        insert(grid, NodeId::at(static_cast<uint32_t>(rng_.below(kSide)), static_cast<uint32_t>(rng_.below(kSide))),
               *section);
    }
  }
  static void insert(const proto::GridTopology& grid, NodeId n, std::set<Slot>& section) {
    if (grid.isBase(n) || !section.insert(grid.slot(n)).second) return;
    for (NodeId parent : grid.parents(n)) insert(grid, parent, section);
  }

  KeyframeMesh meshOf(const proto::TerrainDomain& domain) const {
    HeldNodes nodes(domain.grid, {corners_, centres_});
    for (const std::set<Slot>* section : {&from_, &to_})
      for (Slot slot : *section) nodes.records().make(slot) = proto::NodeRecord::of(heights_[slot], 0, {}, {});
    proto::CutDelta change;
    change.added.assign(from_.begin(), from_.end());
    nodes.step(change);
    proto::diff({change.added}, {{to_.begin(), to_.end()}}, change);
    nodes.step(change);
    KeyframeMesh mesh;
    MeshBuilder(domain, nodes, {}, EndHeights(), mesh).run();
    return mesh;
  }

  const uint64_t seed_ = testing::UnitTest::GetInstance()->random_seed();
  Rng rng_{seed_};
  std::vector<int32_t> corners_ = std::vector<int32_t>((kRoots + 1) * (kRoots + 1)),
                       centres_ = std::vector<int32_t>(kRoots * kRoots), heights_;
  std::set<Slot> from_, to_;
};

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

// The positions (scene frame, and the height) at the mesh's two ends of a lattice position.
std::optional<std::array<glm::dvec4, 2>> positionsAt(const KeyframeMesh& mesh, const glm::dvec2& p) {
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const uint32_t *v = &mesh.indices[i], a = v[0], b = v[1], c = v[2];
    const glm::dvec2 at = mesh.parameters[a], ab = glm::dvec2(mesh.parameters[b]) - at,
                     ac = glm::dvec2(mesh.parameters[c]) - at;
    const double u = cross(p - at, ac) / cross(ab, ac), w = cross(ab, p - at) / cross(ab, ac);
    if (u < -1e-5 || w < -1e-5 || u + w > 1 + 1e-5) continue;
    const auto mix = [&](const std::vector<glm::vec4>& q) {
      return (1 - u - w) * glm::dvec4(q[a]) + u * glm::dvec4(q[b]) + w * glm::dvec4(q[c]);
    };
    return std::array{mix(mesh.from_positions), mix(mesh.to_positions)};
  }
  return std::nullopt;
}

double areaOf(const KeyframeMesh& mesh) {
  double area = 0;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::dvec2 a = mesh.parameters[mesh.indices[i]], b = mesh.parameters[mesh.indices[i + 1]],
                     c = mesh.parameters[mesh.indices[i + 2]];
    EXPECT_GT(cross(b - a, c - a), 0);
    area += 0.5 * cross(b - a, c - a);
  }
  return area;
}

TEST_F(MeshAtTheBorder, IsTheWholeMeshCutOff) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  size_t cuts = 0;
  for (int i = 0; i < 40; ++i) {
    const proto::FrameKind kind = i % 2 == 0 ? proto::FrameKind::kPlanar : proto::FrameKind::kGeographic;
    const uint32_t samples_x = 18 + static_cast<uint32_t>(rng_.below(16)),
                   samples_y = 18 + static_cast<uint32_t>(rng_.below(16));
    const proto::TerrainDomain whole = domainOf(kSide, kSide, kind), data = domainOf(samples_x, samples_y, kind);
    drawSections(whole.grid);
    const KeyframeMesh all = meshOf(whole), mesh = meshOf(data);
    const glm::vec2 limit(samples_x - 1, samples_y - 1);
    EXPECT_NEAR(areaOf(mesh), limit.x * limit.y, 1e-3) << "the mesh covers the data";
    std::set<std::pair<float, float>> vertices;
    for (const glm::vec2& p : all.parameters) vertices.insert({p.x, p.y});
    const std::set<uint32_t> drawn(mesh.indices.begin(), mesh.indices.end());
    for (uint32_t v : drawn) {
      const glm::vec2 p = mesh.parameters[v];
      ASSERT_LE(p.x, limit.x);
      ASSERT_LE(p.y, limit.y);
      if (!vertices.contains({p.x, p.y})) {
        ASSERT_TRUE(p.x == limit.x || p.y == limit.y) << p.x << ' ' << p.y;
        ++cuts;
      }
      const auto expected = positionsAt(all, p);
      ASSERT_TRUE(expected) << p.x << ' ' << p.y;
      ASSERT_LT(glm::distance(glm::dvec4(mesh.from_positions[v]), (*expected)[0]), kRounding_m) << p.x << ' ' << p.y;
      ASSERT_LT(glm::distance(glm::dvec4(mesh.to_positions[v]), (*expected)[1]), kRounding_m) << p.x << ' ' << p.y;
      if (kind == proto::FrameKind::kGeographic) continue;
      const glm::dvec3 above =
          data.frame.transform().toScene(proto::LatticePosition{p.x, p.y, 0});  // a vertical line of the scene
      ASSERT_NEAR(mesh.from_positions[v].x, above.x, kRounding_m);
      ASSERT_NEAR(mesh.from_positions[v].y, above.y, kRounding_m);
    }
  }
  EXPECT_GT(cuts, 100u);
}

}  // namespace
}  // namespace foreland::oracle
