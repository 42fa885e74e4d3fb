#include "server/occlusion/occluder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "server/embree/embree_device.h"
#include "server/section/height_bounds.h"

namespace foreland::server {

namespace {

using proto::NodeId;

// Of an edge between neighbouring vertices, the diagonals of squares included. On a triangle with two sides along the
// axes the gradient is then at most sqrt(2) times that.
constexpr double kEdgeSteepness = 1;
constexpr uint32_t kGridSquares = 128;  // of an Embree grid, a side

// Vertices of the surface, row by row; as many as fit between the data's borders.
class Vertices {
 public:
  Vertices(const Hierarchy& hierarchy, uint32_t stride) : hierarchy_(hierarchy), bounds_(hierarchy), stride_(stride) {
    const proto::GridShape& shape = hierarchy.grid().shape();
    columns_ = (shape.samples_x - 1) / stride + 1;
    rows_ = (shape.samples_y - 1) / stride + 1;
    points_.reserve(size_t{columns_} * rows_);
    for (uint32_t j = 0; j < rows_; ++j)
      for (uint32_t i = 0; i < columns_; ++i) points_.push_back(sample(i * stride, j * stride));
  }

  uint32_t columns() const { return columns_; }
  uint32_t rows() const { return rows_; }
  const std::vector<glm::dvec3>& points() const { return points_; }

  // Lowers each vertex by as much as any triangle about it rises above the terrain. A triangle's corners then are all
  // lowered by what it takes to bring it below.
  void lowerBelowTerrain() {
    std::vector<double> excess(points_.size(), 0);
    for (uint32_t j = 0; j + 1 < rows_; ++j)
      for (uint32_t i = 0; i + 1 < columns_; ++i) {
        const double most = excessOf(i, j);
        for (size_t v : {at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)}) excess[v] = std::max(excess[v], most);
      }
    for (size_t v = 0; v < points_.size(); ++v) points_[v].z -= excess[v];
  }

  // Lowers vertices until no edge is steeper than kEdgeSteepness.
  void flatten() {
    for (bool has_changed = true; has_changed;) {
      has_changed = false;
      for (uint32_t j = 0; j < rows_; ++j)
        for (uint32_t i = 0; i < columns_; ++i) has_changed |= lowerTo(i, j, -1);
      for (uint32_t j = rows_; j-- > 0;)
        for (uint32_t i = columns_; i-- > 0;) has_changed |= lowerTo(i, j, 1);
    }
  }

 private:
  size_t at(uint32_t i, uint32_t j) const { return size_t{j} * columns_ + i; }
  glm::dvec3 sample(uint32_t x, uint32_t y) const {
    const NodeId v = NodeId::at(x, y);
    return hierarchy_.frame().position(v, bounds_.lowest(v));
  }

  // How far the square's two triangles, whichever way it is cut, rise above the terrain at most. Both surfaces are
  // linear on triangles; their edges cross at samples and at the middles of the squares between four samples, so the
  // largest difference is at one of these. A terrain's square is cut along either diagonal: the lower middle is taken.
  double excessOf(uint32_t i, uint32_t j) const {
    const double a = points_[at(i, j)].z, b = points_[at(i + 1, j)].z, c = points_[at(i, j + 1)].z,
                 d = points_[at(i + 1, j + 1)].z;
    const auto excess = [&](double u, double v, double terrain_m) {
      const double rising = u > v ? a + u * (b - a) + v * (d - b) : a + v * (c - a) + u * (d - c);
      const double falling = u + v < 1 ? a + u * (b - a) + v * (c - a) : d + (1 - u) * (c - d) + (1 - v) * (b - d);
      return std::max(rising, falling) - terrain_m;
    };
    const auto z = [&](uint32_t x, uint32_t y) { return sample(i * stride_ + x, j * stride_ + y).z; };
    double most = 0;
    for (uint32_t y = 0; y < stride_; ++y)
      for (uint32_t x = 0; x < stride_; ++x) {
        const double corner = z(x, y), right = z(x + 1, y), up = z(x, y + 1), opposite = z(x + 1, y + 1);
        const double middle = 0.5 * std::min(corner + opposite, right + up), n = stride_;
        most = std::max({most, excess(x / n, y / n, corner), excess((x + 1) / n, y / n, right),
                         excess(x / n, (y + 1) / n, up), excess((x + 1) / n, (y + 1) / n, opposite),
                         excess((x + 0.5) / n, (y + 0.5) / n, middle)});
      }
    return most;
  }

  // By the neighbours before (-1) or after (1) it in the order of rows.
  bool lowerTo(uint32_t i, uint32_t j, int step) {
    const int64_t neighbours[4][2] = {{step, 0}, {-1, step}, {0, step}, {1, step}};
    glm::dvec3& p = points_[at(i, j)];
    bool has_changed = false;
    for (const auto& [di, dj] : neighbours) {
      const int64_t x = i + di, y = j + dj;
      if (x < 0 || y < 0 || x >= columns_ || y >= rows_) continue;
      const glm::dvec3& q = points_[at(static_cast<uint32_t>(x), static_cast<uint32_t>(y))];
      const double most = q.z + kEdgeSteepness * glm::length(glm::dvec2(p) - glm::dvec2(q));
      if (p.z > most + 1e-6) {
        p.z = most;
        has_changed = true;
      }
    }
    return has_changed;
  }

  const Hierarchy& hierarchy_;
  HeightBounds bounds_;
  uint32_t stride_, columns_ = 0, rows_ = 0;
  std::vector<glm::dvec3> points_;
};

uint32_t strideFor(const proto::GridShape& shape, size_t max_vertices) {
  uint32_t stride = 1;
  while (size_t{shape.samples_x / stride} * (shape.samples_y / stride) > max_vertices) stride *= 2;
  return stride;
}

std::vector<RTCGrid> gridsOf(const Vertices& vertices) {
  std::vector<RTCGrid> grids;
  for (uint32_t j = 0; j + 1 < vertices.rows(); j += kGridSquares)
    for (uint32_t i = 0; i + 1 < vertices.columns(); i += kGridSquares)
      grids.push_back({j * vertices.columns() + i, vertices.columns(),
                       static_cast<uint16_t>(std::min(kGridSquares + 1, vertices.columns() - i)),
                       static_cast<uint16_t>(std::min(kGridSquares + 1, vertices.rows() - j))});
  return grids;
}

}  // namespace

struct Occluder::Embree {
  explicit Embree(size_t max_bytes) : device(EmbreeDevice::Threads::kAll, max_bytes) {}

  Status build(const Vertices& vertices, const glm::dvec3& origin) {
    scene = device.newScene();
    const RTCGeometry geometry = rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_GRID);
    const bool is_filled = scene != nullptr && geometry != nullptr && fill(geometry, vertices, origin);
    const RTCError refusal = is_filled ? RTC_ERROR_NONE : device.error();
    if (is_filled) {
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene.get(), geometry);
    }
    if (geometry != nullptr) rtcReleaseGeometry(geometry);
    if (!is_filled) return errorOf(refusal);
    rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(scene.get());
    const RTCError failure = device.error();
    return failure == RTC_ERROR_NONE ? Status() : errorOf(failure);
  }

  EmbreeDevice device;
  EmbreeScene scene;

 private:
  // False if Embree has no memory for it.
  static bool fill(RTCGeometry geometry, const Vertices& vertices, const glm::dvec3& origin) {
    const auto& points = vertices.points();
    auto* position = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), points.size() + 1));
    if (position == nullptr) return false;
    for (const glm::dvec3& p : points)
      for (int axis = 0; axis < 3; ++axis)
        *position++ = static_cast<float>(p[axis] - origin[axis] - (axis == 2 ? kBelow_m : 0));
    const std::vector<RTCGrid> grids = gridsOf(vertices);
    auto* buffer = static_cast<RTCGrid*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), grids.size()));
    if (buffer == nullptr) return false;
    std::copy(grids.begin(), grids.end(), buffer);
    return true;
  }

  static Error errorOf(RTCError failure) {
    if (failure == RTC_ERROR_OUT_OF_MEMORY)
      return {ErrorCode::kLimit,
              "occlusion: the surface that rays are cast on does not fit into memory; serve the scene with --occlusion "
              "off"};
    return {ErrorCode::kUnsupported, "occlusion: Embree refuses the surface that rays are cast on with its error " +
                                         std::to_string(failure) + "; serve the scene with --occlusion off"};
  }
};

Occluder::~Occluder() = default;

Result<std::shared_ptr<const Occluder>> Occluder::create(const Hierarchy& hierarchy, const OccluderOptions& options) {
  const proto::GridShape& shape = hierarchy.grid().shape();
  std::shared_ptr<Occluder> occluder(new Occluder);
  occluder->stride_ = strideFor(shape, options.max_vertices);
  const glm::dvec3 low = hierarchy.frame().position(NodeId::at(0, 0), 0),
                   high = hierarchy.frame().position(NodeId::at(shape.samples_x - 1, shape.samples_y - 1), 0);
  if (glm::distance(low, high) > 1.5 * kMaxExtent_m)
    return Error{ErrorCode::kUnsupported,
                 "occlusion: the scene extends beyond " + std::to_string(int(kMaxExtent_m / 1000)) +
                     " km, where up is no longer one direction; serve it with --occlusion off"};
  Vertices vertices(hierarchy, occluder->stride_);
  vertices.lowerBelowTerrain();
  vertices.flatten();
  occluder->origin_ = vertices.points()[vertices.points().size() / 2];
  occluder->steepness_ = std::sqrt(2.0) * kEdgeSteepness;
  occluder->embree_ = std::make_unique<Embree>(options.max_bytes);
  if (const Status status = occluder->embree_->build(vertices, occluder->origin_); !status.ok()) return status.error();
  occluder->bytes_ = occluder->embree_->device.bytes();
  return std::shared_ptr<const Occluder>(std::move(occluder));
}

// Embree looks for a hit from a ray's origin on: what hides a place is mostly near to it, so the ray comes from there.
bool Occluder::blocks(const glm::dvec3& from, const glm::dvec3& way) const {
  RTCRay ray = embreeRay(glm::vec3(from - origin_), glm::vec3(way));
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(embree_->scene.get(), &context, &ray);
  return ray.tfar < 0;
}

}  // namespace foreland::server
