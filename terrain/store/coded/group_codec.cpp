#include "terrain/store/coded/group_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <vector>

#include "proto/codec/prediction_context.h"

namespace foreland::terrain {

namespace {

using proto::kPageSlots;
using proto::NodeId;
using proto::NodeRecord;
using proto::QuantisedError;
using proto::Slot;
using proto::VertexHeight;

// Halves of octaves, rounded down; 0 of 0 and 1.
int halfOctaves(uint32_t x) {
  const int octave = static_cast<int>(std::bit_width(x));
  return octave < 2 ? 0 : 2 * (octave - 1) + static_cast<int>(x >> (octave - 2) & 1);
}

// The first slot of the page at a place, counted in pages.
Slot slotOfPage(const CodedTerrain& terrain, uint64_t page) {
  if (page < terrain.directory.wholeSlots() / kPageSlots) return page * kPageSlots;
  const auto blocks = terrain.directory.blocks();
  const auto after = std::ranges::upper_bound(blocks, page, {}, &proto::PageBlock::first);
  const proto::PageBlock& block = *std::prev(after);
  Slot found = 0;
  terrain.directory.forEachPage(block, [&](Slot first, uint64_t place) { found = place == page ? first : found; });
  return found;
}

// The records of nodes while a group is coded: those of the group itself are `own`, and earlier(place) knows those
// before it.
template <class Earlier>
class GroupNodes {
 public:
  GroupNodes(const CodedTerrain& terrain, const Earlier& earlier, uint64_t first, std::span<const NodeRecord> own)
      : terrain_(terrain), earlier_(earlier), first_(first), own_(own) {}
  const NodeRecord& at(Slot slot) const {
    static constexpr NodeRecord kNone{};
    const uint64_t place = terrain_.directory.placeOf(slot);
    if (place - first_ < own_.size()) return own_[place - first_];
    // Only of a damaged directory a node is there whose parent's page is not, or comes later.
    return place < first_ ? earlier_(place) : kNone;
  }
  VertexHeight find(NodeId v) const {
    const int level = terrain_.grid.level(v);
    if (level == 0) return {nullptr, terrain_.base.at(terrain_.grid, v)};
    return {&at(terrain_.grid.slot(v, level)), 0};
  }

 private:
  const CodedTerrain& terrain_;
  const Earlier& earlier_;
  uint64_t first_;
  std::span<const NodeRecord> own_;
};

// What is known of a node before it is coded.
struct Known {
  proto::PredictionContext heights;
  int32_t most = 255;           // the quantised error that its parents allow
  std::optional<int32_t> copy;  // beyond the data, the height of a coarser node that it repeats

  static Known of(const proto::PredictionContext::Neighbours& neighbours, int level) {
    Known known{proto::PredictionContext::of(neighbours), 255, {}};
    if (level > 1)
      for (const VertexHeight& parent : neighbours.apexes)
        known.most = std::min<int32_t>(known.most, parent.record->error().value);
    return known;
  }
  int32_t middle() const { return heights.ends >> 1; }
};

// Codes the pages of a group, with a coder that reads, writes or counts.
template <class Coder>
class GroupCoder {
 public:
  GroupCoder(const CodedTerrain& terrain, PageModel& model, Coder& coder)
      : terrain_(terrain),
        model_(model),
        coder_(coder),
        symbols_(coder, model.escape),
        quantum_m_(terrain.frame.height_quantum_m),
        quantum_halves_(QuantisedError::roundUp(quantum_m_).value) {}

  // `records` are those of the page; a decoder fills them. `nodes` knows those before it.
  template <class Nodes>
  void codePage(Slot first, const Nodes& nodes, std::span<NodeRecord> records, bool is_encoder) {
    const int level = levelOf(first);
    const bool is_verbatim =
        coder_.code(model_.is_verbatim[was_verbatim_ ? 1 : 0], is_encoder && !isAsBuilt(first, level, nodes, records));
    was_verbatim_ = is_verbatim;
    if (is_verbatim) return codeVerbatim(records);
    proto::QuantisedRadius radius;
    bool has_nodes = false;
    for (uint32_t low = 0; low < kPageSlots; ++low) {
      const NodeId n = terrain_.grid.node(first + low);
      if (n == NodeId{}) {
        records[low] = {};
        continue;
      }
      if (!has_nodes) radius = codeRadius(records[low].radius());
      has_nodes = true;
      const Known known = knownOf(nodes, n, level);
      const int32_t height = codeHeight(known, records[low].height());
      const QuantisedError error = codeError(known, n, level, height, records[low].error());
      records[low] = NodeRecord::of(height, height - known.middle(), error, radius);
    }
  }

 private:
  int levelOf(Slot first) const { return terrain_.grid.pagePlace(first).level; }

  template <class Nodes>
  Known knownOf(const Nodes& nodes, NodeId n, int level) const {
    Known known = Known::of(proto::PredictionContext::find(terrain_.grid, nodes, n, level), level);
    const proto::GridShape& shape = terrain_.grid.shape();
    if (shape.is_cube) return known;
    // Lattice points beyond the data have the height of the nearest sample, and so has the last one along their row.
    const NodeId last = NodeId::at(n.x() + 1 >= shape.samples_x ? terrain_.grid.maxX() : n.x(),
                                   n.y() + 1 >= shape.samples_y ? terrain_.grid.maxY() : n.y());
    if (last != n && terrain_.grid.level(last) < level) known.copy = nodes.find(last).height();
    return known;
  }

  // Whether a page's records follow from what is coded of them.
  template <class Nodes>
  bool isAsBuilt(Slot first, int level, const Nodes& nodes, std::span<const NodeRecord> records) const {
    const NodeRecord* one = nullptr;
    for (uint32_t low = 0; low < kPageSlots; ++low) {
      const NodeRecord& r = records[low];
      const NodeId n = terrain_.grid.node(first + low);
      if (n == NodeId{}) {
        if (r != NodeRecord{}) return false;
        continue;
      }
      if (!one) one = &r;
      if (r.radius() != one->radius() || r.radius().value > proto::QuantisedRadius::kMax ||
          r.middle() != knownOf(nodes, n, level).middle() || std::abs(r.height()) > proto::kMaxHeight)
        return false;
    }
    return true;
  }

  void codeVerbatim(std::span<NodeRecord> records) {
    for (NodeRecord& r : records) {
      uint64_t bits = 0;
      for (int part = 0; part < 4; ++part)
        bits |= uint64_t{coder_.codeEvenly(static_cast<uint32_t>(r.bits >> 16 * part & 0xffff), 16)} << 16 * part;
      r.bits = bits;
    }
  }

  proto::QuantisedRadius codeRadius(proto::QuantisedRadius radius) {
    return {static_cast<uint8_t>(symbols_.template tree<7>(model_.radius, radius.value))};
  }

  int32_t codeHeight(const Known& known, int32_t height) {
    if (known.copy)
      return inRange(int64_t{*known.copy} + symbols_.number(model_.copied_height, 0, height - *known.copy));
    const auto& around = known.heights;
    const auto spread = static_cast<uint32_t>(
        std::min<int64_t>(2 * int64_t{around.parent_magnitude} + std::abs(int64_t{around.apex_difference}), 1 << 30));
    const int expected = std::min<int>(halfOctaves(spread + 1), PageModel::kExpected - 1);
    auto& number = model_.height[static_cast<size_t>(expected) * PageModel::kCaps + capOf(known.most, expected)];
    const int32_t curve = around.curve(), guess = around.guess();
    const size_t curvature_sign = 2u * static_cast<uint32_t>(std::abs(curve)) < spread ? 0 : curve < 0 ? 1 : 2;
    return inRange(int64_t{guess} + symbols_.number(number, curvature_sign, height - guess));
  }
  // Only damaged bytes lead outside the range.
  static int32_t inRange(int64_t height) {
    return static_cast<int32_t>(std::clamp<int64_t>(height, -proto::kMaxHeight - 1, proto::kMaxHeight + 1));
  }
  // How the largest error that the parents allow compares with what is expected, in half octaves.
  size_t capOf(int32_t most, int expected) const {
    if (most == 0) return 0;
    const int ratio = most - quantum_halves_ - expected + 6;
    return ratio < 0 ? 1 : std::min<size_t>(2 + static_cast<size_t>(ratio), PageModel::kCaps - 1);
  }

  QuantisedError codeError(const Known& known, NodeId n, int level, int32_t height, QuantisedError error) {
    constexpr int kEscape = 31, kBelow = 6;
    const double own_m = 0.5 * (2.0 * height - known.heights.ends) * quantum_m_ + rise(level);
    const int least = QuantisedError::roundUp(std::abs(own_m)).value;
    const size_t reasons =
        (terrain_.grid.touchesData(n) ? 0u : 1u) + (least == 0 ? 2u : 0u) + (known.most == 0 ? 4u : 0u);
    if (!coder_.code(model_.has_error[reasons], error.value != 0)) return {};
    const auto depth = std::min<size_t>(static_cast<size_t>(terrain_.grid.maxLevel() - level), PageModel::kDepths - 1);
    const auto gap =
        static_cast<size_t>(std::clamp<int>(known.most - least + 2, 0, static_cast<int>(PageModel::kGaps) - 1));
    const int above = error.value - least + kBelow;
    const int symbol = above < 0 || above >= kEscape ? kEscape : above;
    const auto got = static_cast<int>(
        symbols_.template tree<5>(model_.error[depth * PageModel::kGaps + gap], static_cast<uint32_t>(symbol)));
    if (got == kEscape) return {static_cast<uint8_t>(coder_.codeEvenly(error.value, 8))};
    return {static_cast<uint8_t>(std::clamp(least + got - kBelow, 1, 255))};
  }
  // By how much the ground rises over the middle of an edge of a level because the earth is round, about, metres. It
  // tells on which side of a whole step of errors a displacement lies that is on it.
  double rise(int level) const {
    const proto::Frame& f = terrain_.frame;
    if (f.kind == proto::FrameKind::kPlanar) return 0;
    const double step_m = f.semi_major_m * (f.kind == proto::FrameKind::kGlobe ? 1.5707963 / f.face_steps
                                                                               : std::abs(f.latitude_step_rad));
    const double edge_m = step_m * static_cast<double>(2u << ((terrain_.grid.maxLevel() - level) / 2));
    return edge_m * edge_m * (level % 2 == 1 ? 1 : 2) / (8 * f.semi_major_m);
  }

  const CodedTerrain& terrain_;
  PageModel& model_;
  Coder& coder_;
  proto::Symbols<Coder> symbols_;
  double quantum_m_;
  int quantum_halves_;
  bool was_verbatim_ = false;
};

template <class Coder, class Earlier>
void codePages(const CodedTerrain& terrain, const Earlier& earlier, uint64_t group, PageModel& model, Coder& coder,
               std::span<NodeRecord> records, bool is_encoder) {
  GroupCoder<Coder> pages(terrain, model, coder);
  const uint64_t first = terrain.firstOf(group);
  for (uint64_t at = 0; at < records.size(); at += kPageSlots)
    pages.codePage(slotOfPage(terrain, (first + at) / kPageSlots), GroupNodes(terrain, earlier, first, records),
                   records.subspan(at, kPageSlots), is_encoder);
}

// `coder` writes or counts.
template <class Coder>
void writePages(const CodedTerrain& terrain, GroupReader& read, uint64_t group, PageModel& model, Coder& coder) {
  const auto own = read.group(group);
  std::vector<NodeRecord> records(own.begin(), own.end());  // encoders write them again as they read them
  const auto earlier = [&](uint64_t place) -> const NodeRecord& { return read.at(place); };
  codePages(terrain, earlier, group, model, coder, records, true);
}

}  // namespace

uint64_t CodedTerrain::countOf(uint64_t group) const {
  return std::min(kGroupRecords, directory.pageCount() * kPageSlots - firstOf(group));
}

void encodeGroup(const CodedTerrain& terrain, GroupReader& records, uint64_t group, PageModel& model, Bytes& out) {
  proto::RangeEncoder coder(out);
  writePages(terrain, records, group, model, coder);
  coder.finish();
}

bool decodeGroup(const CodedTerrain& terrain, uint64_t group, ByteSpan bytes, PageModel& model,
                 std::span<NodeRecord> out) {
  CHECK_EQ(out.size(), terrain.countOf(group));
  proto::RangeDecoder coder(bytes);
  const auto earlier = [&](uint64_t place) -> const NodeRecord& { return terrain.records[place]; };
  codePages(terrain, earlier, group, model, coder, out, false);
  return coder.atEnd();
}

// How often each context's answer was no, and yes.
struct ModelTrainer::Counts {
  PageModel model;
  std::array<std::array<uint64_t, 2>, kPageContexts> answers{};

  bool code(proto::AdaptiveBit& bit, bool value) {
    ++answers[static_cast<size_t>(&bit - model.contexts().data())][value ? 1 : 0];
    return value;
  }
  static uint32_t codeEvenly(uint32_t value, int) { return value; }
};

ModelTrainer::ModelTrainer() : counts_(std::make_unique<Counts>()) {}
ModelTrainer::~ModelTrainer() = default;

void ModelTrainer::add(const CodedTerrain& terrain, GroupReader& records, uint64_t group) {
  writePages(terrain, records, group, counts_->model, *counts_);
}

ModelStart ModelTrainer::start() const {
  ModelStart start;
  for (size_t i = 0; i < kPageContexts; ++i) start.set(i, counts_->answers[i][0], counts_->answers[i][1]);
  return start;
}

}  // namespace foreland::terrain
