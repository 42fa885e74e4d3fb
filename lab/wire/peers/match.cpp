#include "lab/wire/peers/match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <string>

namespace foreland::lab {

namespace {

constexpr uint32_t kNobody = 0xffffffffu;

using Triangle = std::array<uint32_t, 3>;

std::string textOf(const glm::dvec3& p) {
  return "(" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " + std::to_string(p.z) + ")";
}

// Vertices by square cells of x and y, about one to a cell, none smaller than the tolerance.
class Cells {
 public:
  Cells(const std::vector<glm::dvec3>& points, const Box& box, double tolerance) : points_(points), low_(box.low) {
    const double wide = box.high.x - box.low.x, high = box.high.y - box.low.y;
    size_ =
        std::max({std::sqrt(wide * high / static_cast<double>(points.size())), tolerance, 1e-9 * (wide + high), 1e-12});
    columns_ = static_cast<size_t>(wide / size_) + 1;
    rows_ = static_cast<size_t>(high / size_) + 1;
    first_.assign(columns_ * rows_ + 1, 0);
    for (const glm::dvec3& p : points) ++first_[cellOf(p) + 1];
    for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    members_.resize(points.size());
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    for (uint32_t i = 0; i < points.size(); ++i) members_[next[cellOf(points[i])]++] = i;
  }

  // The nearest point no farther than the tolerance along any axis; kNobody if there is none.
  uint32_t nearest(const glm::dvec3& p, const glm::dvec3& tolerance) const {
    uint32_t best = kNobody;
    const size_t x1 = index(p.x + size_ - low_.x, columns_), y1 = index(p.y + size_ - low_.y, rows_);
    for (size_t y = index(p.y - size_ - low_.y, rows_); y <= y1; ++y)
      for (size_t x = index(p.x - size_ - low_.x, columns_); x <= x1; ++x)
        for (uint32_t i = first_[y * columns_ + x]; i < first_[y * columns_ + x + 1]; ++i) {
          const uint32_t other = members_[i];
          if (glm::any(glm::greaterThan(glm::abs(points_[other] - p), tolerance))) continue;
          if (best == kNobody || glm::distance(points_[other], p) < glm::distance(points_[best], p)) best = other;
        }
    return best;
  }

 private:
  size_t index(double offset, size_t count) const {
    return static_cast<size_t>(std::clamp(std::floor(offset / size_), 0.0, static_cast<double>(count - 1)));
  }
  size_t cellOf(const glm::dvec3& p) const {
    return index(p.y - low_.y, rows_) * columns_ + index(p.x - low_.x, columns_);
  }

  const std::vector<glm::dvec3>& points_;
  glm::dvec3 low_;
  double size_;
  size_t columns_, rows_;
  std::vector<uint32_t> first_, members_;
};

Result<std::vector<uint32_t>> matchVertices(const PeerMesh& original, const PeerCode& code) {
  const Cells cells(original.positions, boxAround(original), std::max(code.tolerance.x, code.tolerance.y));
  std::vector<uint32_t> match;
  std::vector<bool> claimed(original.positions.size());
  for (const glm::dvec3& p : code.decoded.positions) {
    const uint32_t i = cells.nearest(p, code.tolerance);
    if (i == kNobody) return Error{ErrorCode::kMalformed, "vertex " + textOf(p) + " was never encoded"};
    if (claimed[i]) return Error{ErrorCode::kMalformed, "vertex " + textOf(p) + " was decoded twice"};
    claimed[i] = true;
    match.push_back(i);
  }
  return match;
}

// With the smallest vertex first, in order. `name` renames the vertices.
template <class Name>
std::vector<Triangle> triangles(const std::vector<uint32_t>& indices, const Name& name) {
  std::vector<Triangle> all;
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    Triangle t{name(indices[i]), name(indices[i + 1]), name(indices[i + 2])};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    all.push_back(t);
  }
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

Box boxAround(const PeerMesh& mesh) {
  Box box{mesh.positions.front(), mesh.positions.front()};
  for (const glm::dvec3& p : mesh.positions) {
    box.low = glm::min(box.low, p);
    box.high = glm::max(box.high, p);
  }
  return box;
}

Result<std::vector<uint32_t>> matchMeshes(const PeerMesh& original, const PeerCode& code) {
  const PeerMesh& decoded = code.decoded;
  if (decoded.positions.size() != original.positions.size() || decoded.indices.size() != original.indices.size())
    return Error{ErrorCode::kMalformed, std::to_string(decoded.positions.size()) + " vertices and " +
                                            std::to_string(decoded.indices.size()) + " corners were decoded, " +
                                            std::to_string(original.positions.size()) + " and " +
                                            std::to_string(original.indices.size()) + " encoded"};
  for (uint32_t index : decoded.indices)
    if (index >= decoded.positions.size())
      return Error{ErrorCode::kMalformed, "vertex " + std::to_string(index) + " was decoded, but is not there"};
  auto match = matchVertices(original, code);
  if (!match) return match;
  const auto before = triangles(original.indices, [](uint32_t v) { return v; });
  const auto after = triangles(decoded.indices, [&](uint32_t v) { return (*match)[v]; });
  const auto differs = std::mismatch(before.begin(), before.end(), after.begin());
  if (differs.first == before.end()) return match;
  const Triangle& t = *differs.first;
  return Error{ErrorCode::kMalformed, "the triangle at " + textOf(original.positions[t[0]]) + ", " +
                                          textOf(original.positions[t[1]]) + ", " + textOf(original.positions[t[2]]) +
                                          " was not decoded as it was encoded"};
}

}  // namespace foreland::lab
