#include "server/sight/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "server/sight/ground_surface.h"

namespace foreland::server {

namespace {

// The space around a line, in coordinates at right angles: metres along its chord, to the left, and above the way of
// light. A chord may be upright, where those of SightLine::aside() are not at right angles.
class Surroundings {
 public:
  explicit Surroundings(const SightLine& line)
      : from_(line.from()), length_m_(line.lengthMetres()), sag_m_(line.sag()) {
    along_ = line.way() / length_m_;
    const glm::dvec3 level = glm::cross(line.up(), along_),
                     axis = std::fabs(along_.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    left_ = glm::normalize(glm::length(level) > 1e-6 ? level : glm::cross(axis, along_));
    above_ = glm::cross(along_, left_);
    rise_ = glm::dot(line.up(), above_);
    drift_m_ = std::fabs(sag_m_ * glm::dot(line.up(), along_));
  }

  SightLine::Aside of(const glm::dvec3& point) const {
    const glm::dvec3 p = point - from_;
    const double share = glm::dot(p, along_) / length_m_;
    return {share, glm::dot(p, left_), glm::dot(p, above_) + rise_ * 4 * sag_m_ * share * (1 - share)};
  }

  // Whether the line, as far as a share of it, may come within so many metres of a triangle. Between corners the way of
  // light is taken to be straight, which is off by what it bends there.
  bool mayReach(const std::array<SightLine::Aside, 3>& t, double metres, double before) const {
    const auto [first, last] = std::minmax({t[0].share, t[1].share, t[2].share});
    const double around = (metres + drift_m_) / length_m_;
    if (first > before + around || last < -around) return false;
    const double bend_m = std::fabs(rise_ * sag_m_), span = last - first,
                 steepest = 4 * bend_m / length_m_ * (1 + 2 * (std::max(-first, last) + around)),
                 touch_m = metres + steepest * (metres + drift_m_) + bend_m * span * span;
    const auto [right, left] = std::minmax({t[0].left_m, t[1].left_m, t[2].left_m});
    const auto [low, high] = std::minmax({t[0].above_m, t[1].above_m, t[2].above_m});
    return right <= touch_m && left >= -touch_m && low <= touch_m && high >= -touch_m && isMet(t, touch_m);
  }

 private:
  glm::dvec3 from_, along_, left_, above_;
  double length_m_, sag_m_;
  double rise_;     // metres above for one up
  double drift_m_;  // how far along its chord the way of light is shifted
};

}  // namespace

// One line's way down.
class TriangleTree::Walk {
 public:
  Walk(const TriangleTree& tree, const SightLine& line, Wanted wanted, double before, const proto::EpochWeights& time)
      : tree_(tree), line_(line), around_(line), wanted_(wanted), time_(time), before_(before) {}

  void over(uint32_t face) {
    face_ = face;
    const Face roots = tree_.faceOf(face, time_);
    const Corner middle = cornerOf(roots.middle);
    for (size_t i = 0; i < 4 && !isDone(); ++i)
      look(cornerOf(roots.corners[i]), cornerOf(roots.corners[(i + 1) % 4]), middle, 1);
  }
  bool isDone() const { return found_ && wanted_ == Wanted::kAny; }
  std::optional<double> found() const { return found_; }
  uint64_t work() const { return work_; }

 private:
  struct Corner {
    Vertex vertex;
    SightLine::Aside aside;
  };
  Corner cornerOf(const Vertex& vertex) const { return {vertex, around_.of(vertex.position)}; }

  // At a triangle whose longest edge, from a to b, a node of this level halves; or none.
  void look(const Corner& a, const Corner& b, const Corner& apex, int level) {
    ++work_;
    const std::optional<Node> node = tree_.halfway(face_, a.vertex, b.vertex, level, time_);
    if (!around_.mayReach({a.aside, b.aside, apex.aside}, node ? node->error_m : SightLine::kTouch_m, before_)) return;
    if (!node) return test({a.vertex.position, b.vertex.position, apex.vertex.position});
    const Corner half = cornerOf(node->vertex);
    const bool is_a_nearer = a.aside.share < b.aside.share;
    look(is_a_nearer ? a : apex, is_a_nearer ? apex : b, half, level + 1);
    if (isDone()) return;
    look(is_a_nearer ? apex : a, is_a_nearer ? b : apex, half, level + 1);
  }
  void test(const std::array<glm::dvec3, 3>& t) {
    const auto share = line_.meet(t, {line_.aside(t[0]), line_.aside(t[1]), line_.aside(t[2])});
    if (share && *share < before_) found_ = before_ = *share;
  }

  const TriangleTree& tree_;
  const SightLine& line_;
  Surroundings around_;
  Wanted wanted_;
  const proto::EpochWeights& time_;
  double before_;
  uint32_t face_ = 0;
  std::optional<double> found_;
  uint64_t work_ = 0;
};

TriangleTree::TriangleTree(const Hierarchy& hierarchy) : hierarchy_(hierarchy), triangles_(hierarchy) {}

TriangleTree::Vertex TriangleTree::placed(const GlobeTriangles::Vertex& v, const proto::EpochWeights& time) const {
  const double quanta = v.height + offsetAt(hierarchy_.epochs(), hierarchy_.grid(), v.name, time);
  return {v.x, v.y, hierarchy_.frame().position(v.name, quanta)};
}

std::optional<TriangleTree::Node> TriangleTree::halfway(uint32_t face, const Vertex& a, const Vertex& b, int level,
                                                        const proto::EpochWeights& time) const {
  const auto node = triangles_.halfway(face, a.x, a.y, b.x, b.y, level);
  if (!node) return std::nullopt;
  return Node{placed(node->vertex, time), node->error_m};
}

TriangleTree::Face TriangleTree::faceOf(uint32_t face, const proto::EpochWeights& time) const {
  const int32_t side = triangles_.side();
  const auto at = [&](int32_t x, int32_t y) { return placed(triangles_.base(face, x, y), time); };
  return {{at(0, 0), at(side, 0), at(side, side), at(0, side)}, at(side / 2, side / 2)};
}

std::optional<glm::dvec3> TriangleTree::pointAt(double lattice_x, double lattice_y,
                                                const proto::EpochWeights& time) const {
  const double side = triangles_.side();
  if (!(lattice_x >= 0 && lattice_y >= 0 && lattice_x <= side * proto::Cube::kFaces && lattice_y <= side))
    return std::nullopt;
  const uint32_t face = std::min(static_cast<uint32_t>(lattice_x / side), proto::Cube::kFaces - 1);
  const double x = lattice_x - face * side, y = lattice_y;
  // Twice the area of a triangle of two vertices and the position: positive if it lies to the left of the way.
  const auto area = [&](const Vertex& p, const Vertex& q) { return (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x); };
  const Face roots = faceOf(face, time);
  size_t root = 0;  // whose edges from the middle have the position between them
  while (root < 3 &&
         !(area(roots.middle, roots.corners[root]) >= 0 && area(roots.middle, roots.corners[root + 1]) <= 0))
    ++root;
  Vertex a = roots.corners[root], b = roots.corners[(root + 1) % 4], apex = roots.middle;  // counterclockwise
  for (int level = 1;; ++level) {
    const std::optional<Node> node = halfway(face, a, b, level, time);
    if (!node) break;
    const Vertex half = node->vertex;
    if (area(half, apex) >= 0)
      b = a, a = apex, apex = half;
    else
      a = b, b = apex, apex = half;
  }
  const double whole = area(a, b) + area(b, apex) + area(apex, a);
  const double of_b = area(apex, a) / whole, of_apex = area(a, b) / whole;
  return a.position + of_b * (b.position - a.position) + of_apex * (apex.position - a.position);
}

std::optional<double> TriangleTree::meet(const SightLine& line, Wanted wanted, double before,
                                         const proto::EpochWeights& time, uint64_t& work) const {
  if (!(line.lengthMetres() > 0)) return std::nullopt;
  Walk walk(*this, line, wanted, before, time);
  for (uint32_t face = 0; face < proto::Cube::kFaces && !walk.isDone(); ++face) walk.over(face);
  work += walk.work();
  return walk.found();
}

}  // namespace foreland::server
