#include "proto/codec/object_stream.h"

#include <algorithm>
#include <utility>

#include "base/check.h"

namespace foreland::proto {

namespace {

std::shared_ptr<const glm::ivec3[]> movesWithin(const glm::ivec3& position, std::span<const glm::ivec3> moves) {
  if (moves.empty()) return nullptr;
  auto within = std::make_shared<glm::ivec3[]>(moves.size());
  for (size_t k = 0; k < moves.size(); ++k) within[k] = moveWithin(position, moves[k]);
  return within;
}

}  // namespace

ObjectStream::ObjectStream(const ObjectSet& objects)
    : objects_(&objects), has_changed_(objects.size()), known_(objects.models().size()) {
  for (size_t i = 0; i < objects.size(); ++i) cuts_.emplace_back(objects.domain(i).topology());
}

void ObjectStream::begin(const View& view) {
  last_ = std::exchange(view_, view);
  for (KnownPositions& known : known_) known.forgetIfMost(spare_nodes_);
}

void ObjectStream::setMemory(uint64_t bytes) {
  constexpr uint64_t kNodeBytes = 512;  // a node's entry, eight times over: this is a share of the memory
  spare_nodes_ = static_cast<size_t>(bytes / (kNodeBytes * known_.size()));
}

void ObjectStream::restart() {
  for (KnownPositions& known : known_) known.forgetUnused();
  std::fill(has_changed_.begin(), has_changed_.end(), uint8_t{0});
  model_ = {};
  view_.reset();
}

void ObjectStream::hold(size_t object, const Section& section, const ModelNodes& nodes) {
  cuts_[object].hold(section);
  const MeshTopology& mesh = objects_->domain(object).topology();
  const std::span<const glm::ivec3> base = objects_->modelOf(object).base;
  KnownPositions& known = known_[objects_->placement(object).model];
  for (Slot slot : section.slots) {
    const glm::ivec3 position = positionWithin(nodes.records[slot].position);
    if (known.find(slot) == nullptr)
      known.learn(slot, {position, position - middleOfEdge(mesh, base, known, mesh.node(slot)), 0,
                         movesWithin(position, nodes.movesOf(slot))});
    known.use(slot);
  }
}

SurfaceCodecState ObjectStream::endOf(size_t object) {
  const ObjectPlacement& placement = objects_->placement(object);
  std::optional<View> last;
  if (last_) last = placement.toObject(*last_);
  return {.base = objects_->modelOf(object).base,
          .base_moves = objects_->modelOf(object).base_moves,
          .moves_each = objects_->posesOf(object).poses() - 1,
          .quantum_m = objects_->modelOf(object).quantum_m,
          .view = placement.toObject(*view_),
          .last = last,
          .cut = cuts_[object],
          .has_changed = has_changed_[object],
          .known = known_[placement.model],
          .model = model_};
}

void ObjectStream::encode(size_t object, const CutDelta& delta, const ModelNodes& nodes, RangeEncoder& coder,
                          SurfaceBits& bits) {
  encodeSurface(endOf(object), delta, nodes, coder, bits);
}

bool ObjectStream::decode(size_t object, RangeDecoder& coder, CutDelta& delta) {
  const size_t others = nodes_ - cuts_[object].nodeCount();
  const bool is_fine = decodeSurface(endOf(object), coder, kMaxObjectNodes - others, delta);
  nodes_ = others + cuts_[object].nodeCount();
  return is_fine;
}

const glm::ivec3& ObjectStream::position(size_t object, Slot slot) const {
  const KnownPositions::Node* node = known_[objects_->placement(object).model].find(slot);
  CHECK_TRUE(node != nullptr);
  return node->position;
}

std::span<const glm::ivec3> ObjectStream::moves(size_t object, Slot slot) const {
  const KnownPositions::Node* node = known_[objects_->placement(object).model].find(slot);
  CHECK_TRUE(node != nullptr);
  return {node->moves.get(), objects_->posesOf(object).poses() - 1};
}

}  // namespace foreland::proto
