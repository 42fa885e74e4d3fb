#include <algorithm>
#include <cstdint>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "proto/space/frame_grid.h"
#include "terrain/render/full_ground.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;

constexpr size_t kMaxTriangles = size_t{1} << 26;

// What cannot be seen from a place: what an ellipsoid hides that no ground reaches into. What it hides is convex, so a
// triangle with hidden corners is hidden.
class BehindTheBody {
 public:
  BehindTheBody(const Scene& scene, const glm::dvec3& eye) {
    const proto::Frame& frame = scene.frame();
    // A metre for rounding: an ellipsoid is flatter than a surface of constant depth.
    const double depth_m = 1 + sagOf(scene) - std::min(0, scene.heightRange().lowest) * frame.height_quantum_m;
    const double equatorial_m = frame.semi_major_m - depth_m,
                 polar_m = frame.semi_major_m * (1 - frame.flattening) - depth_m;
    stretch_ = 1.0 / glm::dvec3(equatorial_m, equatorial_m, polar_m);
    eye_ = eye * stretch_;
  }
  bool hides(const glm::dvec3& point) const {
    const glm::dvec3 way = point * stretch_ - eye_;
    const double nearest = std::clamp(-glm::dot(eye_, way) / glm::dot(way, way), 0.0, 1.0);
    const glm::dvec3 p = eye_ + nearest * way;
    return glm::dot(p, p) < 1;
  }

 private:
  // How far the middle of the longest edge between vertices of whole levels lies below the arc over it, at most.
  static double sagOf(const Scene& scene) {
    const double edge_rad = 2.0 * 1.6 / scene.frame().face_steps * (1u << scene.grid().shape().sparse_levels / 2);
    return scene.frame().semi_major_m * edge_rad * edge_rad / 8;
  }

  glm::dvec3 stretch_{1}, eye_{0};
};

class FullGlobe final : public FullGround {
 public:
  FullGlobe(std::shared_ptr<const Scene> scene, const glm::dvec3& eye)
      : scene_(std::move(scene)),
        positions_(scene_->frame(), scene_->grid().maxX(), scene_->grid().maxY()),
        body_(*scene_, eye) {
    const auto side = static_cast<int>(scene_->grid().rootSize());
    const glm::ivec2 corners[] = {{0, 0}, {side, 0}, {side, side}, {0, side}};
    for (uint32_t face = 0; face < 6; ++face)
      for (int i = 0; i < 4; ++i)
        halve(vertexAt({face, corners[i]}), vertexAt({face, corners[(i + 1) % 4]}),
              vertexAt({face, glm::ivec2(side / 2)}), 1);
  }

  bool isTooLarge() const override { return triangles_.size() > kMaxTriangles; }

  void addTo(EmbreeScene& embree, const glm::dvec3& origin) const override {
    std::vector<glm::vec3> vertices;
    std::vector<uint32_t> indices;
    vertices.reserve(3 * triangles_.size()), indices.reserve(3 * triangles_.size());
    for (const Triangle& t : triangles_)
      for (const Place& place : t) {
        indices.push_back(static_cast<uint32_t>(vertices.size()));
        vertices.emplace_back(vertexAt(place).position - origin);
      }
    embree.addTriangles(vertices, indices);
  }

  std::array<TriangleCorner, 3> corners(const EmbreeHit& hit) const override {
    std::array<TriangleCorner, 3> out;
    for (size_t i = 0; i < 3; ++i) {
      const Place& place = triangles_[hit.primitive][i];
      const Vertex v = vertexAt(place);
      const glm::dvec2 parameter(place.face * scene_->grid().rootSize() + static_cast<uint32_t>(place.p.x), place.p.y);
      out[i] = {v.position, parameter, scene_->height(v.name) * scene_->frame().height_quantum_m};
    }
    return out;
  }

 private:
  // On the square of a face, whose east and north sides other faces name.
  struct Place {
    uint32_t face = 0;
    glm::ivec2 p{0};
  };
  using Triangle = std::array<Place, 3>;

  struct Vertex : Place {
    NodeId name;
    glm::dvec3 position{0};
  };

  Vertex vertexAt(const Place& at) const {
    const NodeId name = nameOf(at);
    return {at, name, positions_.position(name, scene_->height(name))};
  }
  NodeId nameOf(const Place& at) const { return scene_->grid().cube().name({at.face, at.p.x, at.p.y}); }

  // By bisection, as long as nodes are there; counter-clockwise seen from above.
  void halve(const Vertex& a, const Vertex& b, const Vertex& apex, int level) {
    if (triangles_.size() > kMaxTriangles) return;
    const proto::GridTopology& grid = scene_->grid();
    const Place middle{a.face, (a.p + b.p) / 2};
    if (level <= grid.maxLevel() && scene_->pages().hasPage(grid.slot(nameOf(middle), level))) {
      const Vertex m = vertexAt(middle);
      halve(apex, a, m, level + 1);
      halve(b, apex, m, level + 1);
      return;
    }
    if (body_.hides(a.position) && body_.hides(b.position) && body_.hides(apex.position)) return;
    triangles_.push_back({a, b, apex});
  }

  std::shared_ptr<const Scene> scene_;
  proto::FrameGrid positions_;
  BehindTheBody body_;
  std::vector<Triangle> triangles_;
};

}  // namespace

std::unique_ptr<FullGround> fullGlobe(std::shared_ptr<const Scene> scene, const glm::dvec3& eye) {
  return std::make_unique<FullGlobe>(std::move(scene), eye);
}

}  // namespace foreland::terrain
