#include "proto/surface_codec.h"

#include <algorithm>
#include <cmath>

namespace foreland::proto {

namespace {

constexpr int kOctave = 256;  // of a CompactBound

size_t scaleOf(int64_t size) {
  return std::min<size_t>(static_cast<size_t>(std::bit_width(static_cast<uint64_t>(size))), SurfaceModel::kScales - 1);
}

// One object's records, one after the other, each with its contexts; `find` gives a node's record by slot, or null.
template <class Coder, class Find>
class RecordCoder {
 public:
  RecordCoder(const SurfaceDomain& domain, std::span<const glm::ivec3> base, SurfaceModel& model, Coder& coder,
              const Find& find)
      : mesh_(domain.topology()), base_(base), model_(model), symbols_(coder, model.escape), find_(find) {}

  // An encoder passes the record, a decoder gets it. False for an absurd one.
  bool code(Slot slot, SurfaceRecord& record) {
    const NodeId n = mesh_.node(slot);
    const Expected expected(*this, n);
    const size_t with = expected.parents > 0 ? 1 : 0;
    bool fine = true;
    for (int axis = 0; axis < 3; ++axis) {
      const int64_t guess = int64_t{expected.middle[axis]} + expected.displacement[axis];
      const int64_t got = guess + number(model_.displacement[scaleOf(expected.size)], record.position[axis] - guess);
      fine = fine && std::abs(got) <= kMaxObjectSteps;
      record.position[axis] = static_cast<int32_t>(std::clamp<int64_t>(got, -kMaxObjectSteps, kMaxObjectSteps));
    }
    const size_t turn =
        with == 0 ? 0 : 1 + std::min<size_t>(expected.like.cone_sine.root / 20, SurfaceModel::kScales - 2);
    fine = codeAs(model_.normal[turn], record.normal.x, expected.like.normal.x, -32768, 32767) && fine;
    fine = codeAs(model_.normal[turn], record.normal.y, expected.like.normal.y, -32768, 32767) && fine;
    fine = codeBound(model_.radius[with], record.radius, expected.like.radius.bits - kOctave) && fine;
    fine = codeBound(model_.along[with], record.error_along, expected.like.error_along.bits - 2 * kOctave) && fine;
    const int lean = record.error_along.bits + expected.like.error_across.bits - expected.like.error_along.bits;
    fine = codeBound(model_.across[with], record.error_across, lean) && fine;
    fine = codeAs(model_.cone[with], record.cone_sine.root, expected.like.cone_sine.root * 2 / 3, 0, 255) && fine;
    return codeAs(model_.bulge[with], record.bulge.root, expected.like.bulge.root * 2 / 3, 0, 255) && fine;
  }

 private:
  // What the parents lead to expect.
  struct Expected {
    glm::ivec3 middle, displacement{0};
    int64_t size = 0;    // of the parents' displacements, about
    SurfaceRecord like;  // of the parents: the mean of their normals, the largest of their bounds
    int parents = 0;

    Expected(const RecordCoder& coder, NodeId n) : middle(coder.middleOfEdge(n)) {
      int normal_x = 0, normal_y = 0;
      for (NodeId parent : coder.mesh_.parents(n)) {
        const SurfaceRecord* record = coder.find_(coder.mesh_.slot(parent));
        if (record == nullptr) continue;
        ++parents;
        displacement += record->position - coder.middleOfEdge(parent);
        normal_x += record->normal.x;
        normal_y += record->normal.y;
        like.radius.bits = std::max(like.radius.bits, record->radius.bits);
        like.error_along.bits = std::max(like.error_along.bits, record->error_along.bits);
        like.error_across.bits = std::max(like.error_across.bits, record->error_across.bits);
        like.cone_sine.root = std::max(like.cone_sine.root, record->cone_sine.root);
        like.bulge.root = std::max(like.bulge.root, record->bulge.root);
      }
      if (parents == 0) return;
      displacement /= 4 * parents;
      size = std::max({std::abs(displacement.x), std::abs(displacement.y), std::abs(displacement.z)});
      like.normal = {static_cast<int16_t>(normal_x / parents), static_cast<int16_t>(normal_y / parents)};
    }
  };

  glm::ivec3 positionOf(NodeId v) const {
    if (mesh_.isBase(v)) return base_[baseVertexOf(v)];
    const SurfaceRecord* record = find_(mesh_.slot(v));
    return record == nullptr ? glm::ivec3(0) : record->position;
  }
  glm::ivec3 middleOfEdge(NodeId n) const {
    const auto [a, b] = mesh_.endpoints(n);
    const glm::ivec3 sum = positionOf(a) + positionOf(b);
    return {sum.x >> 1, sum.y >> 1, sum.z >> 1};
  }

  int64_t number(NumberModel& model, int64_t value) { return symbols_.number(model, 0, static_cast<int32_t>(value)); }
  template <class T>
  bool codeAs(NumberModel& model, T& value, int guess, int least, int most) {
    const int64_t got = guess + number(model, value - guess);
    value = static_cast<T>(std::clamp<int64_t>(got, least, most));
    return got >= least && got <= most;
  }
  // Finite ones.
  bool codeBound(NumberModel& model, CompactBound& bound, int guess) {
    return codeAs(model, bound.bits, std::max(guess, 0), 0, 0xfe00);
  }

  const MeshTopology& mesh_;
  std::span<const glm::ivec3> base_;
  SurfaceModel& model_;
  Symbols<Coder> symbols_;
  const Find& find_;
};

}  // namespace

void SurfaceEncoder::onAddable(int, std::span<const Slot> slots) {
  const auto find = [this](Slot slot) { return &records_[slot]; };
  RecordCoder coder(domain_, base_, model_, coder_, find);
  for (Slot slot : slots) {
    SurfaceRecord record = records_[slot];
    coder.code(slot, record);
  }
  sent_ += slots.size();
}

void SurfaceEncoder::load(SurfaceBatch& batch) {
  for (size_t i = 0; i < batch.count; ++i) batch.record[i] = records_[batch.slot[i]];
}

void SurfaceDecoder::onAddable(int, std::span<const Slot> slots) {
  const auto find = [this](Slot slot) -> const SurfaceRecord* {
    const auto it = records_.find(slot);
    return it == records_.end() ? nullptr : &it->second;
  };
  RecordCoder coder(domain_, base_, model_, coder_, find);
  for (Slot slot : slots) {
    SurfaceRecord record;
    if (!isBroken()) absurd_ = !coder.code(slot, record);
    records_[slot] = record;
  }
}

void SurfaceDecoder::load(SurfaceBatch& batch) {
  for (size_t i = 0; i < batch.count; ++i) batch.record[i] = records_[batch.slot[i]];
}

}  // namespace foreland::proto
