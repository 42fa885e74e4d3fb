#include "client/replica.h"

#include <algorithm>
#include <limits>
#include <string>

#include "client/mesh_builder.h"
#include "proto/codec/section_codec.h"

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
      adapter_(*domain_),
      nodes_(domain_->grid, {*corner_heights_, *centre_heights_}),
      object_set_(std::make_unique<proto::ObjectSet>(
          std::move(proto::ObjectSet::create(welcome.models, welcome.objects)).value())) {
  makeObjects();
}

void Replica::makeObjects() {
  objects_.clear();
  for (size_t i = 0; i < object_set_->size(); ++i) objects_.emplace_back(*object_set_, i);
  if (!objects_.empty()) stream_ = std::make_unique<proto::ObjectStream>(*object_set_);
}

std::optional<int32_t> Replica::knownHeight(NodeId v) const {
  const proto::GridTopology& grid = domain_->grid;
  if (!grid.contains(v) || (!grid.isBase(v) && nodes_.in(grid.slot(v)) == 0)) return std::nullopt;
  return nodes_.records().height(v);
}

Status Replica::apply(const proto::KeyframeHeader& header, ByteSpan bytes, Blend blend) {
  if (header.base_index == 0 && to_.index != 0) startAfresh();
  if (broken_) return refused("one before it was none");
  if (header.base_index != to_.index)
    return refused("it starts from keyframe " + std::to_string(header.base_index) + ", held is " +
                   std::to_string(to_.index));
  if (Status s = step(header, bytes); !s.ok()) {
    broken_ = true;
    return s;
  }
  const bool is_first = to_.index == 0;
  from_ = is_first ? header : to_;
  to_ = header;
  const Duration interval = to_.time - from_.time;
  motion_ = Motion::between(proto::viewOf(from_), proto::viewOf(to_), interval);
  this->blend({blend, proto::viewOf(from_), motion_, interval.toSeconds(), is_first}, delta_);
  return {};
}

bool Replica::isUnderWay() const {
  return morphs_.isUnderWay() ||
         std::any_of(objects_.begin(), objects_.end(), [](const ObjectReplica& o) { return o.isUnderWay(); });
}

void Replica::extend(Duration interval, Blend blend) {
  from_ = to_;
  this->blend({blend, proto::viewOf(to_), motion_, interval.toSeconds()}, {});
}

void Replica::blend(const MeshSpan& span, const proto::CutDelta& change) {
  const MorphClock clock(span, span.from, span.motion.metres_per_s);
  morphs_.step(domain_->grid, change, [&](Slot slot) { return intervals(clock, slot); });
  nodes_.step(morphs_.jumped());
  nodes_.step(morphs_.drawn());
  nodes_.forget([this](Slot first) { return adapter_.knowsBlock(first); });
  for (ObjectReplica& object : objects_) object.blend(span, *stream_);
}

// Of the node's sphere. A page that is forgotten has left the frontier long ago; how large its spheres are is not known
// any more, so they might be seen.
double Replica::intervals(const MorphClock& clock, Slot slot) const {
  if (clock.isEven()) return clock.intervals({}, 0);
  const proto::GridTopology& grid = domain_->grid;
  const NodeId n = grid.node(slot);
  const glm::dvec3 centre = domain_->frame.position(n, nodes_.records().at(slot).middle());
  const bool is_known = adapter_.knowsBlock(slot - slot % proto::SparseNodes::kBlockSlots);
  return clock.intervals(centre, is_known ? domain_->radius(grid.level(n), adapter_.radius(slot))
                                          : std::numeric_limits<double>::infinity());
}

// The server does not go on from the section that was presented.
void Replica::startAfresh() {
  adapter_ = proto::TerrainAdapter(*domain_);
  nodes_ = HeldNodes(domain_->grid, {*corner_heights_, *centre_heights_});
  morphs_ = {};
  model_ = {};
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
  proto::QuantisedRadius radius(Slot first) override { return adapter_.radius(first); }
  void load(proto::TerrainBatch&) override {}
  bool decide(int, std::span<const proto::Predicate>, std::span<uint8_t>) override { return false; }

 private:
  const proto::TerrainAdapter& adapter_;
};

}  // namespace

std::optional<proto::Resume> Replica::makeResume(uint64_t scene_id) {
  if (broken_ || to_.index == 0) return std::nullopt;
  proto::HeldSections held{section(), {}};
  for (const ObjectReplica& object : objects_) held.objects.push_back(object.section());
  KnownRadii radii(adapter_);
  adapter_ = proto::TerrainAdapter(*domain_, held.terrain.slots, radii);
  model_ = {};
  if (stream_) stream_->restart();
  proto::Resume resume{scene_id, to_.index, to_.time, fingerprint_, {}};
  proto::encodeSections(domain_->grid, *object_set_, held, resume.section);
  return resume;
}

Status Replica::step(const proto::KeyframeHeader& header, ByteSpan bytes) {
  delta_.added.clear();
  delta_.removed.clear();
  proto::DeltaDecoder decoder(*domain_, nodes_.records(), model_, bytes);
  keepLeaving();
  const bool is_adapted = adapter_.adapt(proto::viewOf(header), proto::kMaxSectionNodes, decoder, scratch_, delta_);
  restoreLeaving();
  if (!is_adapted) {
    if (Status s = decoder.finish(); !s.ok()) return refused(s.error().message);
    return refused("its section is not closed, or too large");
  }
  uint32_t print = fingerprint_ + proto::fingerprint(delta_.added) - proto::fingerprint(delta_.removed);
  if (stream_) stream_->begin(proto::viewOf(header));
  for (ObjectReplica& object : objects_)
    if (!object.step(*stream_, decoder.coder(), print)) return refused("what it has of an object is no delta");
  if (Status s = decoder.finish(); !s.ok()) return refused(s.error().message);
  if (((print ^ header.fingerprint) & header.fingerprint_mask) != 0)
    return refused("the section that results is not the server's");
  fingerprint_ = print;
  return {};
}

// A node that has left the section and is still drawn may come to the frontier again, and then is known by the middle
// of its edge: its record is kept aside. Both have the same middle, which is all that is asked of them there.
void Replica::keepLeaving() {
  leaving_.clear();
  for (const Morph& m : morphs_.all())
    if (!m.comes) leaving_.push_back({m.slot, nodes_.records().at(m.slot)});
}

void Replica::restoreLeaving() {
  for (const Leaving& node : leaving_)
    if (!adapter_.contains(node.slot)) nodes_.records().make(node.slot) = node.record;
}

KeyframeMesh Replica::buildMesh() const {
  KeyframeMesh mesh;
  mesh.from = from_;
  mesh.to = to_;
  MeshBuilder(*this, mesh).run();
  for (const ObjectReplica& object : objects_) object.appendTo(mesh);
  return mesh;
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
    if (!(nodes_.in(grid.slot(vertex(m))) & kInTo)) break;
    const glm::dvec2 rot(-d.y, d.x);
    const bool toward_b = glm::dot(glm::dvec2(x, y) - m, d) > 0;
    const glm::dvec2 in = (rot - d) / 2.0, on = (rot + d) / 2.0;
    m = toward_b ? m + on : m + in;
    d = toward_b ? in : -on;
  }
  const glm::dvec2 rot(-d.y, d.x), offset = glm::dvec2(x, y) - m;
  const double length2 = glm::dot(d, d), along = glm::dot(offset, d) / length2, up = glm::dot(offset, rot) / length2;
  const auto a = knownHeight(vertex(m - d)), b = knownHeight(vertex(m + d)), apex = knownHeight(vertex(m + rot));
  if (!a || !b || !apex) return std::nullopt;
  const double steps = 0.5 * (1 - along - up) * *a + 0.5 * (1 + along - up) * *b + up * *apex;
  return steps * domain_->frame.transform().frame().height_quantum_m;
}

}  // namespace foreland::client
