#include "client/replica.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <string>
#include <utility>

#include "base/sort.h"
#include "client/mesh/weights/spline.h"
#include "proto/codec/section_codec.h"

namespace foreland::client {

using proto::NodeId;
using proto::Slot;

namespace {

Error refused(const std::string& why) {
  return {ErrorCode::kMalformed, "keyframe: " + why + "; this connection cannot continue, reconnect"};
}

void pushEarlier(const proto::KeyframeHeader& header, EarlierKeyframes& earlier) {
  std::shift_right(earlier.headers.begin(), earlier.headers.end(), 1);
  earlier.headers.front() = header;
}

proto::Epochs epochsOf(const proto::Welcome& welcome) {
  return std::move(proto::Epochs::create(welcome.shape, welcome.epochs, welcome.epoch_blend)).value();
}

}  // namespace

// What the last mesh is drawn from.
struct Replica::Drawn {
  HeldNodes nodes;
  Morphs morphs;
  std::vector<ObjectReplica> objects;
  std::unique_ptr<proto::ObjectStream> stream;
  std::unique_ptr<proto::EpochStream> epochs;
  proto::KeyframeHeader from, to;
  EarlierKeyframes earlier;
  uint32_t order;
  uint64_t meshes;
};

Replica::Replica(const proto::Welcome& welcome)
    : domain_(std::make_unique<proto::TerrainDomain>(std::move(proto::GridTopology::create(welcome.shape)).value(),
                                                     welcome.frame, proto::ErrorBound::kSpheroid,
                                                     welcome.highest * welcome.frame.height_quantum_m)),
      corner_heights_(std::make_unique<std::vector<int32_t>>(welcome.corner_heights)),
      centre_heights_(std::make_unique<std::vector<int32_t>>(welcome.centre_heights)),
      adapter_(*domain_),
      nodes_(domain_->grid, {*corner_heights_, *centre_heights_}),
      object_set_(std::make_unique<proto::ObjectSet>(
          std::move(proto::ObjectSet::create(welcome.models, welcome.objects, epochsOf(welcome))).value())) {
  model_.signals_blocks = welcome.occlusion;
  if (!welcome.epochs.empty())
    epochs_ = std::make_unique<proto::EpochStream>(domain_->grid, epochsOf(welcome), welcome.base_offsets);
  makeObjects();
  setMemory(welcome.memory_bytes);
}

void Replica::makeObjects() {
  objects_.clear();
  for (size_t i = 0; i < object_set_->size(); ++i) objects_.emplace_back(*object_set_, i);
  if (!objects_.empty()) stream_ = std::make_unique<proto::ObjectStream>(*object_set_);
}

void Replica::setMemory(uint32_t bytes) {
  adapter_.memory().pages.setBudget(bytes);
  if (stream_) stream_->setMemory(bytes);
}

std::optional<int32_t> Replica::knownHeight(NodeId v) const {
  const proto::GridTopology& grid = domain_->grid;
  if (!grid.contains(v) || (!grid.isBase(v) && nodes_.in(grid.slot(v)) == 0)) return std::nullopt;
  return nodes_.records().height(v);
}

Status Replica::apply(const proto::KeyframeHeader& header, ByteSpan bytes, Blend blend) {
  if (header.base_index == 0 && to_.index != 0) {
    Drawn drawn = reset();
    Status s = apply(header, bytes, blend);
    if (!s.ok()) restore(std::move(drawn));
    return s;
  }
  if (is_broken_ && header.base_index != 0) return refused("an earlier keyframe of this connection was malformed");
  if (header.base_index != to_.index)
    return refused("its delta starts from keyframe " + std::to_string(header.base_index) + ", but the client holds " +
                   std::to_string(to_.index));
  if (Status s = step(header, bytes); !s.ok()) {
    is_broken_ = true;
    return s;
  }
  const bool is_first = to_.index == 0;
  pushEarlier(from_, earlier_);
  from_ = is_first ? header : to_;
  to_ = header;
  if (epochs_) {
    to_.scene_time = epochs_->sceneTime();
    to_.is_scene_step = epochs_->isStep();
    to_.motion_px =
        static_cast<float>(proto::frameTolerance(epochs_->offsets().epochs().blend(), to_.tau_px)) - to_.tau_px;
  }
  if (is_first) {
    from_.scene_time = to_.scene_time;
    from_.motion_px = to_.motion_px;
  }
  const Duration interval = to_.time - from_.time;
  motion_ = Motion::between(proto::viewOf(from_), proto::viewOf(to_), interval);
  this->blend({blend, proto::viewOf(from_), motion_, interval.toSeconds(), is_first}, delta_);
  return {};
}

bool Replica::isInTransition() const {
  return morphs_.isInTransition() ||
         std::any_of(objects_.begin(), objects_.end(), [](const ObjectReplica& o) { return o.isInTransition(); });
}

void Replica::extend(Duration interval, Blend blend) {
  pushEarlier(from_, earlier_);
  from_ = to_;
  this->blend({blend, proto::viewOf(to_), motion_, interval.toSeconds()}, {});
}

void Replica::blend(MeshSpan span, const proto::CutDelta& change) {
  if (epochs_) {
    const proto::Epochs& epochs = epochs_->offsets().epochs();
    span.ground = {epochs.weightsAt(from_.scene_time), epochs.weightsAt(to_.scene_time)};
  }
  const MorphTiming timing(span, span.from, span.motion.metres_per_s);
  showNext(orderOf(span.blend), span.is_first);
  morphs_.step(
      domain_->grid, change, [&](Slot slot) { return intervals(timing, slot); }, order_);
  nodes_.step(morphs_.jumped());
  nodes_.step(morphs_.drawn());
  nodes_.forget([this](Slot first) { return adapter_.knowsBlock(first); });
  for (ObjectReplica& object : objects_) object.blend(span, *stream_);
  if (const glm::dvec3 eye = to_.pose.eye; meshes_++ == 0 || glm::distance(origin_, eye) > kOriginReach_m)
    origin_ = glm::round(eye);
}

// Which keyframes the mesh blends, and the times that it shows: those of its keyframes, blended as they are, from where
// the last mesh ended. After a mesh of order 1, only the keyframe counts that was newest.
void Replica::showNext(uint32_t order, bool is_first) {
  if (is_first) shown_until_ = to_.time;
  if (order_ == 1) earlier_.headers.fill(from_);
  const auto age = [this](uint32_t i) {
    const Time t = i == 0 ? to_.time : i == 1 ? from_.time : earlier_.headers[i - 2].time;
    return static_cast<double>((to_.time - t).us);
  };
  earlier_.count = std::max(order, order_) - 1;  // what the last mesh ended with is shown, too
  earlier_.from_age = from_.time - shown_until_;
  earlier_.to_age = {std::llround(splineEnd(order, age))};
  shown_until_ = to_.time - earlier_.to_age;
  order_ = order;
}

// How many intervals a node's transition takes, by its bounding sphere. The adapter may have forgotten the radii of
// pages that left the frontier; such a node is taken to be visible, with a sphere of any size.
double Replica::intervals(const MorphTiming& timing, Slot slot) const {
  if (timing.isUniform()) return timing.intervals({}, 0);
  const proto::GridTopology& grid = domain_->grid;
  const NodeId n = grid.node(slot);
  const glm::dvec3 centre = domain_->frame.position(n, nodes_.records().at(slot).middle());
  const std::optional<proto::QuantisedRadius> radius = adapter_.radius(slot);
  return timing.intervals(centre,
                          radius ? domain_->radius(grid.level(n), *radius) : std::numeric_limits<double>::infinity());
}

// Back to the state before the first keyframe, but for what is remembered of the terrain and the model: the server has
// sent a keyframe that starts from nothing. Returns what was drawn, for that keyframe may be malformed. Cost: a copy of
// the records, 4 ms where 170,000 nodes are drawn, once a jump.
Replica::Drawn Replica::reset() {
  Drawn drawn{nodes_,
              std::exchange(morphs_, {}),
              std::move(objects_),
              std::move(stream_),
              epochs_ ? std::make_unique<proto::EpochStream>(*epochs_) : nullptr,
              std::exchange(from_, {}),
              std::exchange(to_, {}),
              std::exchange(earlier_, {}),
              std::exchange(order_, 1),
              meshes_++};  // the next mesh follows from none
  fingerprint_ = 0;
  makeObjects();
  setMemory(static_cast<uint32_t>(memory().budget()));
  return drawn;
}

void Replica::restore(Drawn drawn) {
  nodes_ = std::move(drawn.nodes);
  morphs_ = std::move(drawn.morphs);
  objects_ = std::move(drawn.objects);
  stream_ = std::move(drawn.stream);
  epochs_ = std::move(drawn.epochs);
  from_ = drawn.from, to_ = drawn.to;
  earlier_ = drawn.earlier;
  order_ = drawn.order;
  meshes_ = drawn.meshes;
}

namespace {

// The radii of pages as an adapter knows them, for another adapter that is made from a section. Making one loads no
// nodes and decides nothing.
class KnownRadii final : public proto::TerrainSource {
 public:
  explicit KnownRadii(const proto::TerrainAdapter& adapter) : adapter_(adapter) {}
  proto::QuantisedRadius radius(Slot first) override { return *adapter_.radius(first); }
  void load(proto::TerrainBatch&) override {}
  bool decide(int, std::span<const proto::Predicate>, std::span<uint8_t>) override { return false; }

 private:
  const proto::TerrainAdapter& adapter_;
};

}  // namespace

std::optional<proto::Resume> Replica::makeResume(const proto::Welcome& welcome, size_t max_bytes) {
  if (is_broken_ || to_.index == 0) return std::nullopt;
  proto::HeldSections held{section(), {}, {}};
  for (const ObjectReplica& object : objects_) held.objects.push_back(object.section());
  proto::Resume resume{welcome.scene_id, to_.index, to_.time, fingerprint_, {}};
  const std::vector<proto::KnownPage> known = encodeHeld(held, max_bytes, resume.section);

  KnownRadii radii(adapter_);
  proto::TerrainAdapter adapter(*domain_, held.terrain.slots, radii);
  adapter_ = std::move(adapter);
  setMemory(welcome.memory_bytes);
  adapter_.learn(known);
  model_ = proto::DeltaModel::forConnection(welcome.occlusion);
  if (stream_) stream_->restart();
  if (epochs_) epochs_->resume();
  return resume;
}

// The bytes of the sections and of what is remembered, and the pages of what they say is known, with their radii.
std::vector<proto::KnownPage> Replica::encodeHeld(proto::HeldSections& held, size_t max_bytes, Bytes& out) const {
  const std::vector<proto::KnownPage> remembered = memory().pages();
  std::vector<proto::KnownPage> known;
  for (size_t count = remembered.size();; count /= 2) {
    held.known = adapter_.livePages();
    held.known.insert(held.known.end(), remembered.begin(), remembered.begin() + static_cast<std::ptrdiff_t>(count));
    foreland::sort(held.known.begin(), held.known.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
    out.clear();
    known = proto::encodeSections(domain_->grid, *object_set_, held, out);
    if (out.size() <= max_bytes || count == 0) break;
  }
  for (proto::KnownPage& page : known) page.knowledge.radius = *adapter_.radius(page.first);
  return known;
}

Status Replica::step(const proto::KeyframeHeader& header, ByteSpan bytes) {
  delta_.added.clear();
  delta_.removed.clear();
  proto::DeltaDecoder decoder(*domain_, nodes_.records(), model_, bytes);
  if (header.base_index == 0) {
    const proto::Remembered remembered = decoder.codeRestart();
    if (is_broken_ && remembered != proto::Remembered::kNothing)
      return refused("an earlier keyframe of this connection was malformed");
    is_broken_ = false;
    adapter_.restart(remembered);
    if (remembered == proto::Remembered::kNothing) {
      model_ = proto::DeltaModel::forConnection(model_.signals_blocks);
      if (epochs_) epochs_->restart();
    }
    nodes_.clearSections();
  }
  if (!adapt(header, decoder)) {
    if (Status s = decoder.finish(); !s.ok()) return refused(s.error().message);
    return refused("its section is not parent-closed, or too large");
  }
  uint32_t print = fingerprint_ + proto::fingerprint(delta_.added) - proto::fingerprint(delta_.removed);
  if (stream_) stream_->begin(proto::viewOf(header));
  for (ObjectReplica& object : objects_)
    if (!object.step(*stream_, decoder.coder(), print)) return refused("the bytes for an object are no delta");
  if (epochs_ && !epochs_->decode(adapter_, delta_.added, decoder.coder()))
    return refused("the bytes for the ground's motion are no delta");
  if (Status s = decoder.finish(); !s.ok()) return refused(s.error().message);
  if (((print ^ header.fingerprint) & header.fingerprint_mask) != 0)
    return refused("the resulting section is not the server's");
  fingerprint_ = print;
  return {};
}

// Adapts the terrain's section. A removed node that is still drawn may have been forgotten and become addable again,
// and then the decoder writes a record that has only the midpoint of its edge. Drawing needs its true height, so its
// record is saved and restored; both records have the same midpoint, and the adapter uses nothing else of the record of
// a node that is not known.
bool Replica::adapt(const proto::KeyframeHeader& header, proto::DeltaDecoder& decoder) {
  saved_.clear();
  for (const Morph& m : morphs_.all())
    if (!m.is_added) saved_.push_back({m.slot, nodes_.records().at(m.slot)});
  const bool ok = adapter_.adapt(proto::viewOf(header), proto::kMaxSectionNodes, decoder, scratch_, delta_);
  proto::KnownNodes known(adapter_);
  for (const SavedRecord& saved : saved_)
    if (!known.has(saved.slot)) nodes_.records().make(saved.slot) = saved.record;
  return ok;
}

size_t Replica::patcherBytes() const {
  size_t bytes = patcher_ ? patcher_->bytes() : 0;
  for (const ObjectReplica& object : objects_) bytes += object.mesh().bytes();
  return bytes;
}

void Replica::makeEmptyPatch(MeshPatch& out) const {
  out.clear();
  out.from = from_, out.to = to_;
  out.earlier = earlier_;
  out.origin = origin_;
}

void Replica::makePatch(MeshPatch& out) {
  makeEmptyPatch(out);
  const EndHeights heights = this->heights();
  const TerrainStep step{nodes_, morphs_, heights, from_.scene_time, to_.scene_time, origin_, order_};
  const bool follows = patcher_ && patched_ + 1 == meshes_,
             has_new_origin = std::exchange(patched_origin_, origin_) != origin_;
  if (!patcher_) patcher_ = std::make_unique<TerrainPatcher>(*domain_);
  follows ? patcher_->step(step, out.terrain) : patcher_->rebuild(step, out.terrain);
  out.from_nodes = patcher_->fromNodes();
  out.to_nodes = patcher_->toNodes();
  object_patches_.write(objects_, !follows || has_new_origin, origin_, out);
  patched_ = meshes_;
}

namespace {

// A triangle of the terrain's hierarchy over lattice positions: its refinement edge from m - d to m + d, and its apex
// at m + rot(d).
struct HeightTriangle {
  glm::dvec2 m, d;

  glm::dvec2 rot() const { return {-d.y, d.x}; }
  static NodeId vertex(glm::dvec2 p) { return NodeId::at(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y)); }

  // The half that contains p, once the refinement edge is halved.
  HeightTriangle half(glm::dvec2 p) const {
    const glm::dvec2 to_a = (rot() - d) / 2.0, to_b = (rot() + d) / 2.0;
    return glm::dot(p - m, d) > 0 ? HeightTriangle{m + to_b, to_a} : HeightTriangle{m + to_a, -to_b};
  }
  // The weights of p over m - d, m + d and the apex; their sum is 1.
  glm::dvec3 weights(glm::dvec2 p) const {
    const double length2 = glm::dot(d, d), along = glm::dot(p - m, d) / length2, up = glm::dot(p - m, rot()) / length2;
    return {0.5 * (1 - along - up), 0.5 * (1 + along - up), up};
  }
};

// The one of the four triangles of p's root square that contains p. Its apex is the square's centre.
HeightTriangle rootTriangle(const proto::GridTopology& grid, glm::dvec2 p) {
  const proto::GridShape& shape = grid.shape();
  const double size = grid.rootSize(), half = size / 2;
  const double cx = (std::min(std::floor(p.x / size), shape.roots_x - 1.0) + 0.5) * size;
  const double cy = (std::min(std::floor(p.y / size), shape.roots_y - 1.0) + 0.5) * size;
  if (std::fabs(p.y - cy) > std::fabs(p.x - cx))
    return {{cx, p.y < cy ? cy - half : cy + half}, {p.y < cy ? half : -half, 0}};
  return {{p.x > cx ? cx + half : cx - half, cy}, {0, p.x > cx ? half : -half}};
}

}  // namespace

std::optional<double> Replica::heightAt(double x, double y) const {
  const proto::GridTopology& grid = domain_->grid;
  const proto::GridShape& shape = grid.shape();
  if (to_.index == 0 || !(x >= 0 && y >= 0 && x <= shape.samples_x - 1 && y <= shape.samples_y - 1))
    return std::nullopt;
  const glm::dvec2 p(x, y);
  HeightTriangle t = rootTriangle(grid, p);
  const auto root_x = static_cast<uint32_t>(t.m.x + t.rot().x) >> shape.root_log2;
  const auto vertex = [&](glm::dvec2 at) { return grid.nameIn(root_x, HeightTriangle::vertex(at)); };
  for (int level = 1; level <= grid.maxLevel(); ++level) {
    if (!(nodes_.in(grid.slot(vertex(t.m))) & kInTo)) break;
    t = t.half(p);
  }
  const EndHeights heights = this->heights();
  const auto height = [&](proto::NodeId v) {
    const auto known = knownHeight(v);
    return known ? std::optional(heights.at(v, *known, 1)) : std::nullopt;
  };
  const auto a = height(vertex(t.m - t.d)), b = height(vertex(t.m + t.d)), apex = height(vertex(t.m + t.rot()));
  if (!a || !b || !apex) return std::nullopt;
  return glm::dot(t.weights(p), glm::dvec3(*a, *b, *apex)) * domain_->frame.transform().frame().height_quantum_m;
}

}  // namespace foreland::client
