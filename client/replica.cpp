#include "client/replica.h"

#include <string>

#include "client/mesh_builder.h"
#include "proto/section_codec.h"

namespace foreland::client {

using proto::NodeId;
using proto::Slot;

namespace {

Error refused(const std::string& why) {
  return {ErrorCode::kMalformed, "keyframe: " + why + "; the connection is of no use any more, reconnect"};
}

}  // namespace

Replica::Replica(const proto::Welcome& welcome)
    : domain_(std::make_unique<proto::TerrainDomain>(std::move(proto::GridTopology::create(welcome.shape)).value(),
                                                     welcome.frame)),
      corner_heights_(std::make_unique<std::vector<int32_t>>(welcome.corner_heights)),
      centre_heights_(std::make_unique<std::vector<int32_t>>(welcome.centre_heights)),
      known_(domain_->grid, {*corner_heights_, *centre_heights_}),
      adapter_(*domain_),
      object_set_(std::make_unique<proto::ObjectSet>(
          std::move(proto::ObjectSet::create(welcome.models, welcome.objects)).value())) {
  makeObjects();
}

void Replica::makeObjects() {
  objects_.clear();
  for (size_t i = 0; i < object_set_->size(); ++i) objects_.emplace_back(*object_set_, i);
  if (!objects_.empty()) object_model_ = std::make_unique<proto::SurfaceModel>();
}

const int32_t* Replica::knownHeight(NodeId v) const {
  const proto::GridTopology& grid = domain_->grid;
  if (!grid.contains(v)) return nullptr;
  if (grid.isBase(v)) {
    const uint32_t k = grid.shape().root_log2, rx = v.x() >> k, ry = v.y() >> k;
    const bool corner = (v.x() & (grid.rootSize() - 1)) == 0;
    return corner ? &(*corner_heights_)[ry * (grid.shape().roots_x + 1) + rx]
                  : &(*centre_heights_)[ry * grid.shape().roots_x + rx];
  }
  const uint32_t i = nodes_.index.find(grid.slot(v));
  return i == SlotTable::kAbsent ? nullptr : &nodes_.heights[i];
}

Status Replica::apply(const proto::KeyframeHeader& header, ByteSpan bytes) {
  if (header.base_index == 0 && to_.index != 0) startAfresh();
  if (broken_) return refused("one before it was none");
  if (header.base_index != to_.index)
    return refused("it starts from keyframe " + std::to_string(header.base_index) + ", held is " +
                   std::to_string(to_.index));
  if (Status s = step(header, bytes); !s.ok()) {
    broken_ = true;
    return s;
  }
  merge();
  from_ = to_.index == 0 ? header : to_;
  to_ = header;
  forgetUnknown();
  return {};
}

// The server does not go on from the section that was presented.
void Replica::startAfresh() {
  adapter_ = proto::TerrainAdapter(*domain_);
  known_ = proto::SparseNodes(domain_->grid, {*corner_heights_, *centre_heights_});
  model_ = {};
  nodes_ = {};
  fingerprint_ = 0;
  from_ = to_ = {};
  broken_ = false;
  makeObjects();
}

namespace {

// The radii of the pages of a section's nodes, as an adapter knows them. It is asked for nothing else.
class KnownRadii final : public proto::NodeSource<proto::TerrainBatch> {
 public:
  explicit KnownRadii(const proto::TerrainAdapter& adapter) : adapter_(adapter) {}
  proto::RadiusClass radius(Slot first) override { return adapter_.radius(first); }
  void load(proto::TerrainBatch&) override {}
  bool answer(int, std::span<const proto::Question>, std::span<uint8_t>) override { return false; }

 private:
  const proto::TerrainAdapter& adapter_;
};

}  // namespace

std::optional<proto::Resume> Replica::present(uint64_t scene_id) {
  if (broken_ || to_.index == 0) return std::nullopt;
  const proto::Section held = section();
  KnownRadii radii(adapter_);
  adapter_ = proto::TerrainAdapter(*domain_, held.slots, radii);
  model_ = {};
  for (ObjectReplica& object : objects_) object.startAfresh();
  if (object_model_) *object_model_ = {};
  fingerprint_ = proto::fingerprint(held.slots);
  proto::Resume resume{scene_id, to_.index, to_.time, fingerprint_, {}};
  proto::encodeSection(domain_->grid, held, resume.section);
  return resume;
}

Status Replica::step(const proto::KeyframeHeader& header, ByteSpan bytes) {
  delta_.added.clear();
  delta_.removed.clear();
  proto::AdaptScratch scratch;
  proto::DeltaDecoder decoder(*domain_, known_, model_, bytes);
  if (!adapter_.adapt(proto::viewOf(header), proto::kMaxSectionNodes, decoder, scratch, delta_)) {
    if (Status s = decoder.finish(); !s.ok()) return refused(s.error().message);
    return refused("its section is not closed, or too large");
  }
  uint32_t print = fingerprint_ + proto::fingerprint(delta_.added) - proto::fingerprint(delta_.removed);
  for (ObjectReplica& object : objects_)
    if (!object.step(proto::viewOf(header), *object_model_, decoder.coder(), scratch, print))
      return refused("what it has of an object is no delta");
  if (Status s = decoder.finish(); !s.ok()) return refused(s.error().message);
  if (((print ^ header.fingerprint) & header.fingerprint_mask) != 0)
    return refused("the section that results is not the server's");
  fingerprint_ = print;
  return {};
}

// The union of the newest section and the one before; `to` becomes `from`.
void Replica::merge() {
  NodeUnion next;
  const size_t size = nodes_.slots.size() + delta_.added.size();
  next.slots.reserve(size);
  next.heights.reserve(size);
  next.in.reserve(size);
  const auto push = [&](Slot slot, int32_t height, uint8_t in) {
    next.slots.push_back(slot);
    next.heights.push_back(height);
    next.in.push_back(in);
  };
  size_t a = 0, r = 0;
  const auto pushAdded = [&] {
    push(delta_.added[a], known_.at(delta_.added[a]).height(), NodeUnion::kInTo);
    ++a;
  };
  for (size_t i = 0; i < nodes_.slots.size(); ++i) {
    if (!(nodes_.in[i] & NodeUnion::kInTo)) continue;
    const Slot slot = nodes_.slots[i];
    while (a < delta_.added.size() && delta_.added[a] < slot) pushAdded();
    const bool goes = r < delta_.removed.size() && delta_.removed[r] == slot;
    if (goes) ++r;
    push(slot, nodes_.heights[i], goes ? NodeUnion::kInFrom : NodeUnion::kInFrom | NodeUnion::kInTo);
  }
  while (a < delta_.added.size()) pushAdded();
  next.index.build(next.slots);
  nodes_ = std::move(next);
}

// What is not known any more goes once it is as much as what is.
void Replica::forgetUnknown() {
  if (known_.size() < 4 * (adapter_.nodeCount() + 1024)) return;
  proto::SparseNodes kept(domain_->grid, {*corner_heights_, *centre_heights_});
  adapter_.forEachKnown([&](Slot slot) {
    if (known_.has(slot)) kept.make(slot) = known_.at(slot);
  });
  known_ = std::move(kept);
}

KeyframeMesh Replica::buildMesh() const {
  KeyframeMesh mesh;
  mesh.from = from_;
  mesh.to = to_;
  MeshBuilder(*this, mesh).run();
  for (const ObjectReplica& object : objects_) object.appendTo(mesh);
  return mesh;
}

proto::Section Replica::section() const {
  proto::Section section;
  for (size_t i = 0; i < nodes_.slots.size(); ++i)
    if (nodes_.in[i] & NodeUnion::kInTo) section.slots.push_back(nodes_.slots[i]);
  return section;
}

std::optional<double> Replica::heightAt(double x, double y) const {
  const proto::GridTopology& grid = domain_->grid;
  const proto::GridShape& shape = grid.shape();
  if (to_.index == 0 || !(x >= 0 && y >= 0 && x <= shape.samples_x - 1 && y <= shape.samples_y - 1))
    return std::nullopt;
  const double size = grid.rootSize(), half = size / 2;
  const double cx = (std::min(std::floor(x / size), shape.roots_x - 1.0) + 0.5) * size;
  const double cy = (std::min(std::floor(y / size), shape.roots_y - 1.0) + 0.5) * size;
  // The root triangle around (x, y): edge m - d, m + d, apex the root's centre.
  const bool steep = std::fabs(y - cy) > std::fabs(x - cx);
  glm::dvec2 d = steep ? glm::dvec2(y < cy ? half : -half, 0) : glm::dvec2(0, x > cx ? half : -half);
  glm::dvec2 m =
      steep ? glm::dvec2(cx, y < cy ? cy - half : cy + half) : glm::dvec2(x > cx ? cx + half : cx - half, cy);
  const auto vertex = [](glm::dvec2 p) { return NodeId::at(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y)); };
  for (int level = 1; level <= grid.maxLevel(); ++level) {
    const uint32_t i = nodes_.index.find(grid.slot(vertex(m)));
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
  return steps * domain_->frame.transform().frame().height_step_m;
}

}  // namespace foreland::client
