#include "lab/tiles/tile_tree.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "lab/wire/peers/draco_peer.h"
#include "lab/wire/peers/quantized_mesh.h"
#include "oracle/oracle.h"
#include "oracle/surface/oracle_eye.h"

namespace foreland::lab {

namespace {

// Where the eye sees a point; nothing if it does not.
std::optional<glm::dvec2> seenAt(const oracle::OracleEye& eye, const glm::dvec3& point) {
  if (eye.depth(point) <= oracle::Oracle::kDefaultNear_m) return std::nullopt;
  const glm::dvec2 at = eye.project(point);
  return eye.sees(at) ? std::optional(at) : std::nullopt;
}

}  // namespace

bool TileId::isIn(const TileId& other) const {
  if (level < other.level) return false;
  const uint32_t up = level - other.level;
  return x >> up == other.x && y >> up == other.y;
}

TileTree::TileTree(std::shared_ptr<const terrain::Scene> scene)
    : scene_(std::move(scene)),
      frame_(scene_->frame(), scene_->grid().shape().samples_x - 1, scene_->grid().shape().samples_y - 1),
      last_x_(scene_->grid().shape().samples_x - 1),
      last_y_(scene_->grid().shape().samples_y - 1) {
  while (kCells << finest_ < std::max(last_x_, last_y_)) ++finest_;
  const proto::NodeId middle = proto::NodeId::at(last_x_ / 2, last_y_ / 2),
                      beside = proto::NodeId::at(last_x_ / 2, last_y_ / 2 + 1);
  spacing_m_ = glm::distance(frame_.position(middle, 0), frame_.position(beside, 0));
}

std::vector<TileId> TileTree::children(const TileId& tile) const {
  std::vector<TileId> all;
  if (tile.level == finest_) return all;
  const uint32_t side = kCells * stride(tile.level + 1);
  for (uint32_t y = 2 * tile.y; y < 2 * tile.y + 2; ++y)
    for (uint32_t x = 2 * tile.x; x < 2 * tile.x + 2; ++x)
      if (x * side < last_x_ && y * side < last_y_) all.push_back({tile.level + 1, x, y});
  return all;
}

std::vector<uint32_t> TileTree::lines(uint32_t index, uint32_t level, uint32_t last) const {
  std::vector<uint32_t> all;
  const uint32_t step = stride(level), begin = index * kCells * step;
  for (uint32_t i = 0; i <= kCells; ++i) {
    all.push_back(std::min(begin + i * step, last));
    if (all.back() == last) break;
  }
  return all;
}

const TileTree::TileBox& TileTree::box(const TileId& tile) {
  const auto known = boxes_.find(tile);
  if (known != boxes_.end()) return known->second;
  const auto xs = lines(tile.x, tile.level, last_x_), ys = lines(tile.y, tile.level, last_y_);
  const proto::NodeId middle = proto::NodeId::at(xs[xs.size() / 2], ys[ys.size() / 2]);
  const glm::dvec3 centre = frame_.position(middle, 0), up = frame_.transform().upAt(centre);
  const glm::dvec3 east = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), up)), north = glm::cross(up, east);
  TileBox box{centre, {}, {east, north, up}};
  glm::dvec3 low(1e30), high(-1e30);
  for (const uint32_t y : ys)
    for (const uint32_t x : xs) {
      const glm::dvec3 p = frame_.position(proto::NodeId::at(x, y), height(x, y)) - centre;
      const glm::dvec3 along(glm::dot(p, east), glm::dot(p, north), glm::dot(p, up));
      low = glm::min(low, along), high = glm::max(high, along);
    }
  box.half = 0.5 * (high - low);
  const glm::dvec3 middle_of = 0.5 * (high + low);
  box.centre += east * middle_of.x + north * middle_of.y + up * middle_of.z;
  return boxes_[tile] = box;
}

double TileTree::screenError(const TileId& tile, const proto::Pose& pose, const proto::Lens& lens) {
  const TileBox& b = box(tile);
  glm::dvec3 beyond;
  for (int i = 0; i < 3; ++i)
    beyond[i] = std::max(0.0, std::fabs(glm::dot(pose.eye - b.centre, b.axes[static_cast<size_t>(i)])) - b.half[i]);
  return geometricError(tile.level) * lens.focalPx() / std::max(1.0, glm::length(beyond));
}

// Unless all corners lie beyond one side of the view.
bool TileTree::isInView(const TileId& tile, const proto::Pose& pose, const proto::Lens& lens) {
  const TileBox& b = box(tile);
  const double slope_y = lens.tanHalfFov(), slope_x = slope_y * lens.width_px / lens.height_px;
  std::array<int, 5> beyond{};
  for (int corner = 0; corner < 8; ++corner) {
    glm::dvec3 at = b.centre;
    for (int i = 0; i < 3; ++i) at += b.axes[static_cast<size_t>(i)] * (corner >> i & 1 ? b.half[i] : -b.half[i]);
    const glm::dvec3 p = glm::conjugate(pose.orientation) * (at - pose.eye);
    const std::array<bool, 5> outside{-p.z<1, p.x> - p.z * slope_x, p.x<p.z * slope_x, p.y> - p.z * slope_y,
                                      p.y < p.z * slope_y};
    for (size_t side = 0; side < 5; ++side) beyond[side] += outside[side];
  }
  return std::find(beyond.begin(), beyond.end(), 8) == beyond.end();
}

PeerMesh TileTree::mesh(const TileId& tile) const {
  const auto xs = lines(tile.x, tile.level, last_x_), ys = lines(tile.y, tile.level, last_y_);
  PeerMesh mesh;
  for (const uint32_t y : ys)
    for (const uint32_t x : xs) mesh.positions.emplace_back(x - xs[0], y - ys[0], height(x, y));
  const auto columns = static_cast<uint32_t>(xs.size());
  for (uint32_t row = 0; row + 1 < ys.size(); ++row)
    for (uint32_t column = 0; column + 1 < columns; ++column) {
      const uint32_t a = row * columns + column, b = a + 1, c = a + columns, d = c + 1;
      for (const uint32_t index : {a, b, d, a, d, c}) mesh.indices.push_back(index);
    }
  return mesh;
}

Result<size_t> TileTree::bytes(const TileId& tile, TileCodec codec) {
  size_t& known = bytes_[tile][static_cast<size_t>(codec)];
  if (known > 0) return known;
  if (codec == TileCodec::kQuantizedMesh) return known = gzip(encodeQuantizedMesh(mesh(tile))).size();
  const auto code = codeDracoExactly(mesh(tile));
  if (!code) return code.error();
  return known = code->bytes.size();
}

size_t TileTree::triangles(const TileId& tile) const {
  return 2 * (lines(tile.x, tile.level, last_x_).size() - 1) * (lines(tile.y, tile.level, last_y_).size() - 1);
}

double TileTree::heightAt(const TileId& tile, uint32_t x, uint32_t y) const {
  const uint32_t step = stride(tile.level);
  const uint32_t x0 = x == last_x_ ? (x - 1) / step * step : x / step * step,
                 y0 = y == last_y_ ? (y - 1) / step * step : y / step * step;
  const uint32_t x1 = std::min(x0 + step, last_x_), y1 = std::min(y0 + step, last_y_);
  const double u = static_cast<double>(x - x0) / (x1 - x0), v = static_cast<double>(y - y0) / (y1 - y0);
  const double a = height(x0, y0), d = height(x1, y1);
  if (u >= v) return a + u * (height(x1, y0) - a) + v * (d - height(x1, y0));
  return a + v * (height(x0, y1) - a) + u * (d - height(x0, y1));
}

double TileTree::jump(const TileId& fine, const TileId& coarse, const proto::Pose& pose,
                      const proto::Lens& lens) const {
  const oracle::OracleEye eye(pose, lens);
  double most = 0;
  for (const uint32_t y : lines(fine.y, fine.level, last_y_))
    for (const uint32_t x : lines(fine.x, fine.level, last_x_)) {
      const proto::NodeId at = proto::NodeId::at(x, y);
      const auto before = seenAt(eye, frame_.position(at, height(x, y)));
      if (!before) continue;
      const auto after = seenAt(eye, frame_.position(at, heightAt(coarse, x, y)));
      if (after) most = std::max(most, glm::distance(*before, *after));
    }
  return most;
}

client::KeyframeMesh TileTree::drawn(const std::vector<TileId>& tiles, const glm::dvec3& origin) const {
  client::KeyframeMesh all;
  all.origin = origin;
  for (const TileId& tile : tiles) {
    const PeerMesh m = mesh(tile);
    const auto first = static_cast<uint32_t>(all.from_positions.size());
    const uint32_t side = kCells * stride(tile.level);
    for (const glm::dvec3& p : m.positions) {
      const auto x = tile.x * side + static_cast<uint32_t>(p.x), y = tile.y * side + static_cast<uint32_t>(p.y);
      const glm::dvec3 at = frame_.position(proto::NodeId::at(x, y), p.z) - origin;
      all.from_positions.emplace_back(glm::vec3(at), static_cast<float>(p.z * scene_->frame().height_quantum_m));
      all.parameters.emplace_back(x, y);
    }
    for (const uint32_t index : m.indices) all.indices.push_back(first + index);
  }
  all.to_positions = all.from_positions;
  return all;
}

}  // namespace foreland::lab
