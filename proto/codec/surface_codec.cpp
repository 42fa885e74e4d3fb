#include "proto/codec/surface_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/check.h"
#include "base/sort.h"

namespace foreland::proto {

namespace {

glm::ivec3 middleOf(const glm::ivec3& a, const glm::ivec3& b) {
  const glm::ivec3 sum = a + b;
  return {sum.x >> 1, sum.y >> 1, sum.z >> 1};
}

constexpr int64_t kMaxMove = 2 * int64_t{kMaxObjectQuanta};

size_t scaleOf(int64_t size) {
  return std::min<size_t>(static_cast<size_t>(std::bit_width(static_cast<uint64_t>(size))), SurfaceModel::kScales - 1);
}

// Where on the screen a view has a point, and how large lengths look there: what decisions about nodes depend on.
class ViewContext {
 public:
  ViewContext(const View& view, double quantum_m)
      : eye_(view.pose.eye),
        right_(view.pose.right()),
        up_(view.pose.up()),
        forward_(view.pose.forward()),
        quantum_m_(quantum_m),
        tan_y_(view.lens.tanHalfFov()) {
    tan_x_ = tan_y_ * view.lens.width_px / view.lens.height_px;
    const double per_tau = view.lens.focalPx() / view.tau_px;
    scale_ = per_tau * per_tau;
  }

  glm::dvec3 offset(const glm::ivec3& p) const {
    return {p.x * quantum_m_ - eye_.x, p.y * quantum_m_ - eye_.y, p.z * quantum_m_ - eye_.z};
  }
  // How large lengths look there: tolerances to a metre, squared.
  double size(const glm::dvec3& o) const {
    return scale_ / (o.x * o.x + o.y * o.y + o.z * o.z + quantum_m_ * quantum_m_);
  }
  // 0 about the middle of the screen, 6 far outside, 7 behind.
  size_t screen(const glm::dvec3& o) const {
    const double depth = glm::dot(o, forward_);
    if (!(depth > 0)) return 7;
    const double out = std::max(std::fabs(glm::dot(o, right_)) / tan_x_, std::fabs(glm::dot(o, up_)) / tan_y_) / depth;
    size_t at = 0;
    for (double edge : {0.6, 0.85, 0.95, 1.05, 1.2, 1.5}) at += out >= edge ? 1 : 0;
    return at;
  }

 private:
  glm::dvec3 eye_, right_, up_, forward_;
  double quantum_m_, tan_x_ = 0, tan_y_, scale_ = 0;
};

// A node on the frontier as both ends know it.
struct EdgeContext {
  glm::ivec3 middle;             // of its edge
  glm::ivec3 displacement{0};    // sum of the parents'
  std::array<int64_t, 3> sizes;  // by axis: sum of the sizes of their displacements
  int parents = 0;
};

enum class Change : uint8_t { kRemoved, kAdded };

// Codes a change of the section. `Changes` is a ChangeSource, which says what is to be written, or a ChangeSink, which
// takes what was read and says whether reading has failed.
template <class Coder, class Changes>
class Transcoder {
 public:
  Transcoder(const SurfaceCodecState& end, Coder& coder, Changes& changes)
      : end_(end),
        cut_(end.cut),
        mesh_(end.cut.mesh()),
        coder_(coder),
        symbols_(coder, end.model.escape),
        changes_(changes),
        now_(end.view, end.quantum_m) {
    if (end.last) before_.emplace(*end.last, end.quantum_m);
  }

  bool run() {
    const size_t context = (end_.has_changed != 0 ? 2u : 0u) + (cut_.nodeCount() > 0 ? 1u : 0u);
    end_.has_changed = coder_.code(end_.model.changes[context], changes_.wantsAny()) ? 1 : 0;
    if (end_.has_changed == 0) return !changes_.hasFailed(cut_);
    cut_.beginStep();
    for (int level = mesh_.maxLevel(); level >= 1; --level)
      if (!walk(Change::kRemoved, level)) return false;
    for (int level = 1; level <= mesh_.maxLevel(); ++level)
      if (!walk(Change::kAdded, level)) return false;
    cut_.endStep();
    return true;
  }

 private:
  bool walk(Change change, int level) {
    size_t before = 0;  // whether anything changed in the last two blocks
    for (const SurfaceCut::Pages::PageName& name : cut_.pagesOf(level)) {
      const SlotBits candidates = candidatesOf(cut_.page(name.number), change);
      for (uint8_t word = 0; word < 4; ++word) {
        if (candidates.words[word] == 0) continue;
        const bool any = walkBlock(change, level, name.number, word, candidates.words[word], before);
        before = (2 * before + (any ? 1 : 0)) & 3;
        if (changes_.hasFailed(cut_)) return false;
      }
    }
    return true;
  }
  bool walkBlock(Change change, int level, uint32_t page, uint8_t word, uint64_t candidates, size_t before) {
    const Slot page_begin = cut_.page(page).first(), first = page_begin + word * 64u;
    uint64_t wanted = 0;
    for (uint64_t bits = candidates; bits != 0; bits &= bits - 1)
      if (changes_.wants(change, first + static_cast<Slot>(std::countr_zero(bits)))) wanted |= bits & -bits;
    if (!coder_.code(blockContext(change, std::popcount(candidates), before), wanted != 0)) return false;
    const auto nodes = mesh_.pageNodes(level, page_begin);
    bool any = false;
    for (uint64_t bits = candidates; bits != 0; bits &= bits - 1) {
      const int at = std::countr_zero(bits);
      const auto low = static_cast<uint8_t>(word * 64 + at);
      const Slot slot = first + static_cast<Slot>(at);
      const NodeId n = nodes.at(low);
      const bool is_implied = !any && (bits & (bits - 1)) == 0;
      if (!is_implied && !coder_.code(contextOf(change, n, level), wanted >> at & 1)) continue;
      any = true;
      if (change == Change::kRemoved)
        remove(page, low, slot);
      else
        add(page, low, n, slot, level);
    }
    return true;
  }

  void remove(uint32_t page, uint8_t low, Slot slot) {
    cut_.remove(page, low);
    end_.known.release(slot);
    changes_.onRemoved(slot);
  }
  void add(uint32_t page, uint8_t low, NodeId n, Slot slot, int level) {
    if (end_.known.find(slot) == nullptr) {
      changes_.beginPosition(coder_);
      const glm::ivec3 position = codePosition(n, level, changes_.position(slot));
      end_.known.learn(slot, {position, position - middleOfEdge(n), 0, codeMoves(n, slot, position)});
      changes_.endPosition(coder_);
    }
    end_.known.use(slot);
    cut_.add(page, low);
    changes_.onAdded(slot);
  }

  static SlotBits candidatesOf(const SurfaceCut::Page& page, Change change) {
    return change == Change::kRemoved ? page.leaves() : page.addable();
  }

  glm::ivec3 middleOfEdge(NodeId n) const { return proto::middleOfEdge(mesh_, end_.base, end_.known, n); }
  EdgeContext edgeContextOf(NodeId n, int level) const {
    EdgeContext around{.middle = middleOfEdge(n), .sizes = {}};
    for (NodeId parent : mesh_.parents(n)) {
      const glm::ivec3& d = end_.known.find(mesh_.slot(parent, level - 1))->displacement;
      around.displacement += d;
      for (int axis = 0; axis < 3; ++axis) around.sizes[static_cast<size_t>(axis)] += std::abs(d[axis]);
      ++around.parents;
    }
    return around;
  }

  // A decision about a node.
  AdaptiveBit& contextOf(Change change, NodeId n, int level) {
    const glm::ivec3 middle = middleOfEdge(n);
    const glm::dvec3 offset = now_.offset(middle);
    const size_t context =
        (static_cast<size_t>(std::min(level, 4) - 1) * SurfaceModel::kTrends + trendOf(middle, offset)) *
            SurfaceModel::kScreens +
        now_.screen(offset);
    if (change == Change::kRemoved) return end_.model.removed[context];
    return end_.model.added[(isNew(n, level) ? SurfaceModel::kSiblings : 0) + siblingsOf(n, level)][context];
  }
  // How many of its parents' other children are there, 3 for more.
  size_t siblingsOf(NodeId n, int level) const {
    size_t count = 0;
    for (NodeId parent : mesh_.parents(n))
      for (NodeId child : mesh_.children(parent)) {
        if (child != n && cut_.contains(mesh_.slot(child, level))) ++count;
        if (count == SurfaceModel::kSiblings - 1) return count;
      }
    return count;
  }
  // Whether things look larger than they did at the last view.
  size_t trendOf(const glm::ivec3& position, const glm::dvec3& offset) const {
    if (!before_) return 2;
    const double grown = now_.size(offset) / before_->size(before_->offset(position));
    size_t trend = 0;
    for (double edge : {0.95, 0.995, 1.005, 1.05}) trend += grown >= edge ? 1 : 0;
    return trend;
  }

  // A node's position: what both ends expect, and a number for each axis.
  glm::ivec3 codePosition(NodeId n, int level, const glm::ivec3& position) {
    const EdgeContext around = edgeContextOf(n, level);
    glm::ivec3 got;
    int64_t most = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int count = std::max(around.parents, 1);
      const int64_t guess = int64_t{around.middle[axis]} + around.displacement[axis] / (4 * count);
      const int64_t all = around.sizes[0] + around.sizes[1] + around.sizes[2];
      const int64_t like = (all + 3 * around.sizes[static_cast<size_t>(axis)]) / (4 * count);
      const size_t prior = axis == 0 ? 0 : most * 8 < like ? 1 : most * 3 < like ? 2 : 3;
      auto& model = end_.model.position[prior * SurfaceModel::kScales + scaleOf(like)];
      const int64_t off = symbols_.number(model, 0, static_cast<int32_t>(position[axis] - guess));
      most = std::max(most, std::abs(off));
      if (std::abs(guess + off) > kMaxObjectQuanta) changes_.fail();
      got[axis] = static_cast<int32_t>(std::clamp<int64_t>(guess + off, -kMaxObjectQuanta, kMaxObjectQuanta));
    }
    return got;
  }

  std::span<const glm::ivec3> movesOf(NodeId v) const {
    return proto::movesOf(mesh_, end_.base_moves, end_.moves_each, end_.known, v);
  }
  // A node's moves. In each pose it is expected to move as the middle of its edge does, and as much beside that as in
  // the pose before.
  std::shared_ptr<const glm::ivec3[]> codeMoves(NodeId n, Slot slot, const glm::ivec3& position) {
    if (end_.moves_each == 0) return nullptr;
    auto moves = std::make_shared<glm::ivec3[]>(end_.moves_each);
    const auto ends = mesh_.endpoints(n);
    const std::span<const glm::ivec3> a = movesOf(ends[0]), b = movesOf(ends[1]);
    glm::ivec3 beside(0);
    for (size_t k = 0; k < end_.moves_each; ++k) {
      const glm::ivec3 middle = middleOf(a[k], b[k]);
      const glm::ivec3 wanted = changes_.move(slot, k, position);
      int64_t like = 0, most = 0;
      for (int axis = 0; axis < 3; ++axis)
        like += 4 * std::abs(int64_t{beside[axis]}) + std::abs(int64_t{a[k][axis]} - b[k][axis]);
      for (int axis = 0; axis < 3; ++axis) {
        const int64_t guess = std::clamp<int64_t>(int64_t{middle[axis]} + beside[axis], -kMaxMove, kMaxMove);
        const size_t prior = axis == 0 ? 0 : most == 0 ? 1 : most * 8 < like ? 2 : 3;
        auto& model = end_.model.move[prior * SurfaceModel::kScales + scaleOf(like)];
        const int64_t off = symbols_.number(model, 0, static_cast<int32_t>(wanted[axis] - guess));
        most = std::max(most, std::abs(off));
        moves[k][axis] = changes_.withinReach(position[axis], guess + off);
      }
      beside = moves[k] - middle;
    }
    return moves;
  }

  AdaptiveBit& blockContext(Change change, int candidates, size_t before) {
    const auto width = static_cast<size_t>(std::bit_width(static_cast<unsigned>(candidates)));
    return end_.model.blocks[static_cast<size_t>(change)][width * 4 + before];
  }

  bool isNew(NodeId n, int level) const {
    for (NodeId parent : mesh_.parents(n))
      if (cut_.wasAdded(mesh_.slot(parent, level - 1))) return true;
    return false;
  }

  SurfaceCodecState end_;
  SurfaceCut& cut_;
  const MeshTopology& mesh_;
  Coder& coder_;
  Symbols<Coder> symbols_;
  Changes& changes_;
  ViewContext now_;
  std::optional<ViewContext> before_;
};

class ChangeSource {
 public:
  ChangeSource(const CutDelta& delta, const ModelNodes& nodes, SurfaceBits& bits)
      : delta_(delta), nodes_(nodes), bits_(bits) {}
  bool wantsAny() const { return !delta_.added.empty() || !delta_.removed.empty(); }
  bool wants(Change change, Slot slot) const {
    const auto& slots = change == Change::kRemoved ? delta_.removed : delta_.added;
    return std::binary_search(slots.begin(), slots.end(), slot);
  }
  glm::ivec3 position(Slot slot) const { return positionWithin(nodes_.records[slot].position); }
  glm::ivec3 move(Slot slot, size_t k, const glm::ivec3& position) const {
    return moveWithin(position, nodes_.movesOf(slot)[k]);
  }
  int32_t withinReach(int32_t, int64_t move) const { return static_cast<int32_t>(move); }
  void beginPosition(const RangeEncoder& coder) { bits_.positions -= coder.bits(); }
  void endPosition(const RangeEncoder& coder) {
    bits_.positions += coder.bits();
    ++bits_.positions_sent;
  }
  void onRemoved(Slot) { ++changed_; }
  void onAdded(Slot) { ++changed_; }
  void fail() { CHECK_TRUE(false); }
  bool hasFailed(const SurfaceCut&) const { return false; }
  bool isDone() const { return changed_ == delta_.added.size() + delta_.removed.size(); }

 private:
  const CutDelta& delta_;
  const ModelNodes& nodes_;
  SurfaceBits& bits_;
  size_t changed_ = 0;
};

class ChangeSink {
 public:
  ChangeSink(const RangeDecoder& coder, size_t max_nodes, CutDelta& delta)
      : coder_(coder), max_nodes_(max_nodes), delta_(delta) {}
  bool wantsAny() const { return false; }
  bool wants(Change, Slot) const { return false; }
  glm::ivec3 position(Slot) const { return glm::ivec3(0); }
  glm::ivec3 move(Slot, size_t, const glm::ivec3&) const { return glm::ivec3(0); }
  int32_t withinReach(int32_t position, int64_t move) {
    const int64_t least = -int64_t{kMaxObjectQuanta} - position, most = int64_t{kMaxObjectQuanta} - position;
    if (move < least || move > most) fail();
    return static_cast<int32_t>(std::clamp(move, least, most));
  }
  void beginPosition(const RangeDecoder&) {}
  void endPosition(const RangeDecoder&) {}
  void onRemoved(Slot slot) { delta_.removed.push_back(slot); }
  void onAdded(Slot slot) { delta_.added.push_back(slot); }
  void fail() { absurd_ = true; }
  bool hasFailed(const SurfaceCut& cut) const { return absurd_ || coder_.overrun() || cut.nodeCount() > max_nodes_; }

 private:
  const RangeDecoder& coder_;
  size_t max_nodes_;
  CutDelta& delta_;
  bool absurd_ = false;
};

}  // namespace

void KnownPositions::forgetUnused() {
  std::erase_if(nodes_, [](const auto& node) { return node.second.uses == 0; });
}

glm::ivec3 middleOfEdge(const MeshTopology& mesh, std::span<const glm::ivec3> base, const KnownPositions& known,
                        NodeId n) {
  const auto positionOf = [&](NodeId v) {
    return mesh.isBase(v) ? base[baseVertexOf(v)] : known.find(mesh.slot(v))->position;
  };
  const auto [a, b] = mesh.endpoints(n);
  return middleOf(positionOf(a), positionOf(b));
}

std::span<const glm::ivec3> movesOf(const MeshTopology& mesh, std::span<const glm::ivec3> base_moves, size_t each,
                                    const KnownPositions& known, NodeId v) {
  return mesh.isBase(v) ? base_moves.subspan(baseVertexOf(v) * each, each)
                        : std::span<const glm::ivec3>(known.find(mesh.slot(v))->moves.get(), each);
}

void encodeSurface(const SurfaceCodecState& end, const CutDelta& delta, const ModelNodes& nodes, RangeEncoder& coder,
                   SurfaceBits& bits) {
  const double before = coder.bits() - bits.positions;
  ChangeSource changes(delta, nodes, bits);
  CHECK_TRUE(Transcoder(end, coder, changes).run());
  CHECK_TRUE(changes.isDone());
  bits.structure += coder.bits() - bits.positions - before;
  bits.added += delta.added.size();
}

bool decodeSurface(const SurfaceCodecState& end, RangeDecoder& coder, size_t max_nodes, CutDelta& delta) {
  ChangeSink changes(coder, max_nodes, delta);
  if (!Transcoder(end, coder, changes).run()) return false;
  foreland::sort(delta.removed.begin(), delta.removed.end());
  return true;
}

}  // namespace foreland::proto
