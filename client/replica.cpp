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
      adapter_(*domain_),
      nodes_(domain_->grid, {*corner_heights_, *centre_heights_}),
      object_set_(std::make_unique<proto::ObjectSet>(
          std::move(proto::ObjectSet::create(welcome.models, welcome.objects)).value())) {
  makeObjects();
}

void Replica::makeObjects() {
  objects_.clear();
  for (size_t i = 0; i < object_set_->size(); ++i) objects_.emplace_back(*object_set_, i);
  if (!objects_.empty()) object_model_ = std::make_unique<proto::SurfaceModel>();
}

std::optional<int32_t> Replica::knownHeight(NodeId v) const {
  const proto::GridTopology& grid = domain_->grid;
  if (!grid.contains(v) || (!grid.isBase(v) && nodes_.in(grid.slot(v)) == 0)) return std::nullopt;
  return nodes_.records().height(v);
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
  nodes_.step(delta_);
  nodes_.forget([this](Slot first) { return adapter_.knowsBlock(first); });
  from_ = to_.index == 0 ? header : to_;
  to_ = header;
  return {};
}

// The server does not go on from the section that was presented.
void Replica::startAfresh() {
  adapter_ = proto::TerrainAdapter(*domain_);
  nodes_ = HeldNodes(domain_->grid, {*corner_heights_, *centre_heights_});
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
  proto::DeltaDecoder decoder(*domain_, nodes_.records(), model_, bytes);
  if (!adapter_.adapt(proto::viewOf(header), proto::kMaxSectionNodes, decoder, scratch_, delta_)) {
    if (Status s = decoder.finish(); !s.ok()) return refused(s.error().message);
    return refused("its section is not closed, or too large");
  }
  uint32_t print = fingerprint_ + proto::fingerprint(delta_.added) - proto::fingerprint(delta_.removed);
  for (ObjectReplica& object : objects_)
    if (!object.step(proto::viewOf(header), *object_model_, decoder.coder(), scratch_, print))
      return refused("what it has of an object is no delta");
  if (Status s = decoder.finish(); !s.ok()) return refused(s.error().message);
  if (((print ^ header.fingerprint) & header.fingerprint_mask) != 0)
    return refused("the section that results is not the server's");
  fingerprint_ = print;
  return {};
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
    if (!(nodes_.in(grid.slot(vertex(m))) & HeldNodes::kInTo)) break;
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
  return steps * domain_->frame.transform().frame().height_step_m;
}

}  // namespace foreland::client
