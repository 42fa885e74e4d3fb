#include "client/replica.h"

#include <string>

#include "client/mesh_builder.h"

namespace foreland::client {

using proto::NodeId;
using proto::Slot;

namespace {

Error refused(const std::string& why) {
  return {ErrorCode::kMalformed, "keyframe: " + why + "; the connection is of no use any more, reconnect"};
}

// Merges the newest section of `old` with `delta` into the union of before and after.
// Returns an Error if a removed slot is absent or an added one present.
Status merge(const NodeUnion& old, const proto::HeightDelta& delta, NodeUnion& next) {
  const auto& [added, removed] = delta.cut;
  const size_t size = old.slots.size() + added.size();
  next.slots.reserve(size);
  next.heights.reserve(size);
  next.in.reserve(size);
  const auto push = [&](Slot slot, int32_t height, uint8_t in) {
    next.slots.push_back(slot);
    next.heights.push_back(height);
    next.in.push_back(in);
  };
  size_t a = 0, r = 0;
  for (size_t i = 0; i < old.slots.size(); ++i) {
    if (!(old.in[i] & NodeUnion::kInTo)) continue;
    const Slot slot = old.slots[i];
    for (; a < added.size() && added[a] < slot; ++a) push(added[a], delta.heights[a], NodeUnion::kInTo);
    if (a < added.size() && added[a] == slot) return refused("it adds a node that is already there");
    const bool goes = r < removed.size() && removed[r] == slot;
    if (goes) ++r;
    push(slot, old.heights[i], goes ? NodeUnion::kInFrom : NodeUnion::kInFrom | NodeUnion::kInTo);
  }
  for (; a < added.size(); ++a) push(added[a], delta.heights[a], NodeUnion::kInTo);
  if (r != removed.size()) return refused("it removes a node that is not there");
  return {};
}

// The newest section. A node that has just left is not of it: it may come back with its height sent again.
class NewestNodes final : public proto::HeldNodes {
 public:
  explicit NewestNodes(const Replica& replica) : replica_(replica) {}
  bool has(Slot slot) const override {
    const uint32_t i = replica_.nodes().index.find(slot);
    return i != SlotTable::kAbsent && (replica_.nodes().in[i] & NodeUnion::kInTo);
  }
  int32_t height(NodeId v) const override {
    const int32_t* height = replica_.knownHeight(v);
    return height ? *height : 0;
  }

 private:
  const Replica& replica_;
};

}  // namespace

Replica::Replica(const proto::Welcome& welcome)
    : grid_(std::move(proto::GridTopology::create(welcome.shape)).value()),
      frame_(welcome.frame, grid_.maxX(), grid_.maxY()),
      corner_heights_(welcome.corner_heights),
      centre_heights_(welcome.centre_heights) {}

const int32_t* Replica::knownHeight(NodeId v) const {
  if (!grid_.contains(v)) return nullptr;
  if (grid_.isBase(v)) {
    const uint32_t k = grid_.shape().root_log2, rx = v.x() >> k, ry = v.y() >> k;
    const bool corner = (v.x() & (grid_.rootSize() - 1)) == 0;
    return corner ? &corner_heights_[ry * (grid_.shape().roots_x + 1) + rx]
                  : &centre_heights_[ry * grid_.shape().roots_x + rx];
  }
  const uint32_t i = nodes_.index.find(grid_.slot(v));
  return i == SlotTable::kAbsent ? nullptr : &nodes_.heights[i];
}

Status Replica::apply(const proto::KeyframeHeader& header, ByteSpan bytes) {
  if (header.base_index != to_.index)
    return refused("it starts from keyframe " + std::to_string(header.base_index) + ", held is " +
                   std::to_string(to_.index));
  proto::HeightDelta delta;
  proto::DeltaModel model = header.base_index == 0 ? proto::DeltaModel{} : model_;
  if (Status s = proto::decodeDelta(grid_, frame_, bytes, proto::viewOf(header), NewestNodes(*this), model, delta);
      !s.ok())
    return s;
  NodeUnion next;
  if (Status s = merge(nodes_, delta, next); !s.ok()) return s;
  next.index.build(next.slots);
  if (Status s = checkClosure(next, delta.cut); !s.ok()) return s;
  const uint32_t print = fingerprint_ + proto::fingerprint(delta.cut.added) - proto::fingerprint(delta.cut.removed);
  if (print != header.fingerprint) return refused("the section that results is not the server's");

  nodes_ = std::move(next);
  model_ = model;
  delta_ = std::move(delta);
  fingerprint_ = print;
  from_ = to_.index == 0 ? header : to_;
  to_ = header;
  return {};
}

// The old section was closed, so only added nodes can lack a parent and only parents of kept nodes can be missed.
Status Replica::checkClosure(const NodeUnion& next, const proto::CutDelta& cut) const {
  const auto stays = [&](NodeId n) {
    const uint32_t i = next.index.find(grid_.slot(n));
    return i != SlotTable::kAbsent && (next.in[i] & NodeUnion::kInTo);
  };
  for (Slot slot : cut.added)
    for (NodeId parent : grid_.parents(grid_.node(slot)))
      if (!stays(parent)) return refused("it adds a node without its parent");
  for (Slot slot : cut.removed)
    for (NodeId child : grid_.children(grid_.node(slot)))
      if (stays(child)) return refused("it removes a node whose child stays");
  return {};
}

KeyframeMesh Replica::buildMesh() const {
  KeyframeMesh mesh;
  mesh.from = from_;
  mesh.to = to_;
  MeshBuilder(*this, mesh).run();
  return mesh;
}

proto::Section Replica::section() const {
  proto::Section section;
  for (size_t i = 0; i < nodes_.slots.size(); ++i)
    if (nodes_.in[i] & NodeUnion::kInTo) section.slots.push_back(nodes_.slots[i]);
  return section;
}

std::optional<double> Replica::heightAt(double x, double y) const {
  const proto::GridShape& shape = grid_.shape();
  if (to_.index == 0 || !(x >= 0 && y >= 0 && x <= shape.samples_x - 1 && y <= shape.samples_y - 1))
    return std::nullopt;
  const double size = grid_.rootSize(), half = size / 2;
  const double cx = (std::min(std::floor(x / size), shape.roots_x - 1.0) + 0.5) * size;
  const double cy = (std::min(std::floor(y / size), shape.roots_y - 1.0) + 0.5) * size;
  // The root triangle around (x, y): edge m - d, m + d, apex the root's centre.
  const bool steep = std::fabs(y - cy) > std::fabs(x - cx);
  glm::dvec2 d = steep ? glm::dvec2(y < cy ? half : -half, 0) : glm::dvec2(0, x > cx ? half : -half);
  glm::dvec2 m =
      steep ? glm::dvec2(cx, y < cy ? cy - half : cy + half) : glm::dvec2(x > cx ? cx + half : cx - half, cy);
  const auto vertex = [](glm::dvec2 p) { return NodeId::at(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y)); };
  for (int level = 1; level <= grid_.maxLevel(); ++level) {
    const uint32_t i = nodes_.index.find(grid_.slot(vertex(m)));
    if (i == SlotTable::kAbsent || !(nodes_.in[i] & NodeUnion::kInTo)) break;
    const glm::dvec2 rot(-d.y, d.x);
    const bool toward_b = glm::dot(glm::dvec2(x, y) - m, d) > 0;
    const glm::dvec2 in = (rot - d) / 2.0, on = (rot + d) / 2.0;
    m = toward_b ? m + on : m + in;
    d = toward_b ? in : -on;
  }
  const glm::dvec2 rot(-d.y, d.x), offset = glm::dvec2(x, y) - m;
  const double length2 = glm::dot(d, d), along = glm::dot(offset, d) / length2, up = glm::dot(offset, rot) / length2;
  const int32_t *a = knownHeight(vertex(m - d)), *b = knownHeight(vertex(m + d)), *apex = knownHeight(vertex(m + rot));
  if (!a || !b || !apex) return std::nullopt;
  const double steps = 0.5 * (1 - along - up) * *a + 0.5 * (1 + along - up) * *b + up * *apex;
  return steps * frame_.transform().frame().height_step_m;
}

}  // namespace foreland::client
