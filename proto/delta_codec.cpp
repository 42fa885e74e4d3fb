#include "proto/delta_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <string>

namespace foreland::proto {

namespace {

// Nodes that change, by slot: open addressing, grows as it fills.
class ChangeTable {
 public:
  struct Change {
    Slot slot = kNoSlot;
    bool comes = false;
    bool known = false;  // to the decoder by now
    int32_t height = 0;
    int32_t displacement = 0;
  };

  explicit ChangeTable(size_t expected) : cells_(std::bit_ceil(2 * expected + 16)), mask_(cells_.size() - 1) {}

  Change* find(Slot slot) {
    const uint32_t h = slot * 0x85ebca77u >> 16;
    if (!(filter_[h >> 6] >> (h & 63) & 1)) return nullptr;
    for (size_t at = hash(slot) & mask_;; at = (at + 1) & mask_) {
      if (cells_[at].slot == slot) return &cells_[at];
      if (cells_[at].slot == kNoSlot) return nullptr;
    }
  }
  // Valid until the next insertion. The slot is not there yet.
  Change& insert(Slot slot) {
    if (2 * ++count_ > cells_.size()) grow();
    const uint32_t h = slot * 0x85ebca77u >> 16;
    filter_[h >> 6] |= uint64_t{1} << (h & 63);
    size_t at = hash(slot) & mask_;
    while (cells_[at].slot != kNoSlot) at = (at + 1) & mask_;
    cells_[at].slot = slot;
    return cells_[at];
  }
  size_t count() const { return count_; }

 private:
  static size_t hash(Slot slot) {
    const uint32_t h = slot * 0x9e3779b1u;
    return h ^ (h >> 15);
  }
  void grow() {
    std::vector<Change> old(2 * cells_.size());
    old.swap(cells_);
    mask_ = cells_.size() - 1;
    for (const Change& c : old) {
      if (c.slot == kNoSlot) continue;
      size_t at = hash(c.slot) & mask_;
      while (cells_[at].slot != kNoSlot) at = (at + 1) & mask_;
      cells_[at] = c;
    }
  }

  std::array<uint64_t, 1024> filter_{};  // most slots do not change: one bit says so
  std::vector<Change> cells_;
  size_t mask_;
  size_t count_ = 0;
};

// The view as contexts see it.
class Eye {
 public:
  Eye() = default;
  explicit Eye(const DeltaView& v)
      : eye_(v.pose.eye),
        right_(v.pose.right()),
        up_(v.pose.up()),
        forward_(v.pose.forward()),
        ball_(v.ball_m),
        turn_(v.turn_rad) {}

  struct Place {
    double depth, side;  // metres; side: from the nearest side plane of a frustum of 60 by 90 degrees, positive inside
  };
  Place at(const glm::dvec3& p) const {
    const glm::dvec3 d = p - eye_;
    const double x = std::fabs(d.x * right_.x + d.y * right_.y + d.z * right_.z);
    const double y = std::fabs(d.x * up_.x + d.y * up_.y + d.z * up_.z);
    const double z = d.x * forward_.x + d.y * forward_.y + d.z * forward_.z;
    const double side = std::min(z * kSinX - x * kCosX, z * kSinY - y * kCosY);
    return {z, side + ball_ + turn_ * std::fabs(z)};
  }

 private:
  static constexpr double kSinY = 0.5, kCosY = 0.8660254037844386, kSinX = 0.7163007, kCosX = 0.69779;
  glm::dvec3 eye_{0}, right_{0}, up_{0}, forward_{0};
  double ball_ = 0, turn_ = 0;
};

// Halves of octaves, rounded down: floor(2 log2 x) up to the mantissa's linearity. x > 0.
int halfOctaves(double x) { return static_cast<int>(std::bit_cast<uint64_t>(x) >> 51) - 2 * 1023; }

int binOf(double x, const double* edges, int count) {
  int bin = 0;
  while (bin < count && x >= edges[bin]) ++bin;
  return bin;
}
constexpr double kSideEdges[] = {-2, -1, -0.4, 0, 0.4, 1, 3};
constexpr double kShrinkEdges[] = {-0.003, 0.0002, 0.002, 0.005, 0.012, 0.03, 0.08};

struct Cell {
  uint32_t x, y;
  uint8_t near;       // changes seen in the cell above: 0..3
  bool came = false;  // its centre
  uint8_t kids = 0;   // children of the centre before
  uint8_t side = 0, shrink = 0;
  int32_t height = 0;  // of the centre of the cell above, which is near enough
};

struct Added {
  Slot slot;
  int32_t height;
};

template <class Coder>
class Traversal {
 public:
  static constexpr bool kEncodes = std::is_same_v<Coder, RangeEncoder>;

  Traversal(const GridTopology& grid, const FrameGrid& frame, const DeltaView& view, const HeldNodes& held,
            DeltaModel& model, ChangeTable& changes, Coder& coder, size_t most_nodes, DeltaBits* bits)
      : grid_(grid),
        frame_(frame),
        held_(held),
        model_(model),
        changes_(changes),
        coder_(coder),
        most_nodes_(most_nodes),
        bits_(bits),
        now_(view),
        before_(model.has_view ? model.view : view),
        k_(static_cast<int>(grid.shape().root_log2)) {
    const Frame& f = frame.transform().frame();
    step_m_ = f.height_step_m;
    const glm::dvec3 o = frame.position(NodeId::at(0, 0), 0), e = frame.position(NodeId::at(1, 0), 0);
    spacing_m_ = std::sqrt((e.x - o.x) * (e.x - o.x) + (e.y - o.y) * (e.y - o.y) + (e.z - o.z) * (e.z - o.z));
    focal_over_tau_ = 1000 / view.tau_px;
  }

  // For the encoder: the cells with explicit changes, sorted keys by depth.
  std::vector<std::vector<uint64_t>> alive_cells;

  bool run() {
    std::vector<Cell> cells, open;
    const GridShape& shape = grid_.shape();
    for (uint32_t y = 0; y <= shape.roots_y; ++y)
      for (uint32_t x = 0; x <= shape.roots_x; ++x)
        if (x < shape.roots_x || y < shape.roots_y)
          cells.push_back({.x = x,
                           .y = y,
                           .near = 0,
                           .height = x < shape.roots_x && y < shape.roots_y
                                         ? heightOf(centreOf(0, {.x = x, .y = y, .near = 0}))
                                         : 0});
    for (int depth = 0; depth < k_ && !cells.empty(); ++depth) {
      open.clear();
      for (const Cell& cell : cells)
        if (Cell c = cell; opens(depth, c)) open.push_back(c);
      cells.clear();
      for (Cell& cell : open) sides(depth, cell);
      if (failed_) return false;
      for (const Cell& cell : open) descend(depth, cell, cells);
    }
    return true;
  }

  std::vector<Added> added;
  std::vector<Slot> removed;

 private:
  enum class State : uint8_t { kStays, kComes, kGoes, kAbsent };

  uint32_t half(int depth) const { return 1u << (k_ - 1 - depth); }
  NodeId centreOf(int depth, const Cell& c) const {
    const uint32_t s = half(depth);
    return NodeId::at(c.x * 2 * s + s, c.y * 2 * s + s);
  }

  // ---- membership

  bool wasThere(Slot slot) {
    if constexpr (kEncodes)
      return held_.has(slot) != (changes_.find(slot) != nullptr);
    else
      return held_.has(slot);
  }
  // Of nodes that have been decided.
  bool isThere(NodeId n) {
    if (grid_.isBase(n)) return true;
    const Slot slot = grid_.slot(n);
    if constexpr (kEncodes)
      return held_.has(slot);
    else {
      const auto* change = changes_.find(slot);
      return change ? change->comes : held_.has(slot);
    }
  }
  int32_t heightOf(NodeId v) {
    if constexpr (kEncodes)
      return held_.height(v);
    else {
      if (grid_.isBase(v)) return held_.height(v);
      const auto* change = changes_.find(grid_.slot(v));
      return change ? change->height : held_.height(v);
    }
  }
  // How far a vertex lies from the middle of the edge that it refines, steps.
  int32_t displacementOf(NodeId n) {
    if (grid_.isBase(n)) return 0;
    const auto* change = changes_.find(grid_.slot(n));
    if (change && change->known) return change->displacement;
    const auto [a, b] = grid_.endpoints(n);
    return heightOf(n) - ((heightOf(a) + heightOf(b)) >> 1);
  }

  // ---- the walk

  // Codes whether anything happens in the cell; if so, what becomes of its centre. True if its sides and the cells
  // within must be looked at.
  bool opens(int depth, Cell& cell) {
    if (failed_) return false;
    const NodeId c = centreOf(depth, cell);
    if (!grid_.contains(c)) return code(model_.border, kEncodes && isAlive(depth, cell));
    if (depth == 0) return codeAlive(depth, cell, c);
    const Slot slot = grid_.slot(c);
    if (const auto* change = changes_.find(slot); change && change->known) return false;  // went with a parent
    if (wasThere(slot)) {
      if (!codeAlive(depth, cell, c)) return false;
      return !codeGoes(c, slot, 0, cell);
    }
    if (!parentsThere(c)) return false;
    if (!codeComes(c, slot, 0)) return false;
    cell.came = true;
    return true;
  }

  void sides(int depth, Cell& cell) {
    const uint32_t s = half(depth), x = cell.x * 2 * s, y = cell.y * 2 * s;
    uint8_t changed = cell.came ? 2 : 0;
    for (const NodeId n : {NodeId::at(x + s, y), NodeId::at(x, y + s)}) {
      if (failed_ || !grid_.contains(n)) continue;
      const Slot slot = grid_.slot(n);
      if (const auto* change = changes_.find(slot); change && change->known) continue;
      if (wasThere(slot))
        changed += codeGoes(n, slot, 1, cell) ? 1 : 0;
      else if (parentsThere(n))
        changed += codeComes(n, slot, 1) ? 1 : 0;
    }
    cell.near = std::min<uint8_t>(changed, 3);
  }

  void descend(int depth, const Cell& cell, std::vector<Cell>& out) {
    if (depth + 1 >= k_) return;
    const NodeId c = centreOf(depth, cell);
    const int32_t height = grid_.contains(c) && half(depth) >= 4 ? heightOf(c) : cell.height;
    const GridShape& shape = grid_.shape();
    const uint32_t last_x = shape.roots_x << depth, last_y = shape.roots_y << depth;
    for (uint32_t j = 0; j < (cell.y == last_y ? 1u : 2u); ++j)
      for (uint32_t i = 0; i < (cell.x == last_x ? 1u : 2u); ++i)
        out.push_back({.x = 2 * cell.x + i, .y = 2 * cell.y + j, .near = cell.near, .height = height});
  }

  bool parentsThere(NodeId n) {
    for (NodeId p : grid_.parents(n))
      if (!isThere(p)) return false;
    return true;
  }

  // ---- bits

  bool code(AdaptiveBit& bit, bool value) { return coder_.code(bit, value); }

  bool isAlive(int depth, const Cell& cell) const {
    const auto& keys = alive_cells[static_cast<size_t>(depth)];
    return std::binary_search(keys.begin(), keys.end(), uint64_t{cell.y} << 32 | cell.x);
  }

  struct Sight {
    int side, side_before, shrink;
    double depth;
  };
  Sight sightOf(NodeId n, int32_t height, double radius_m) {
    const glm::dvec3 p = frame_.position(n, height);
    const Eye::Place a = now_.at(p), b = before_.at(p);
    Sight s;
    s.side = binOf(a.side / radius_m, kSideEdges, 7);
    s.side_before = binOf(b.side / radius_m, kSideEdges + 2, 3);
    s.depth = std::max(a.depth, 1.0);
    s.shrink = binOf((b.depth - a.depth) / s.depth, kShrinkEdges, 7);
    return s;
  }
  double radiusOf(int depth) const { return 0.75 * 2 * half(depth) * spacing_m_; }

  bool codeAlive(int depth, Cell& cell, NodeId c) {
    int children = 0;
    for (NodeId child : grid_.children(c)) children += wasThere(grid_.slot(child)) ? 1 : 0;
    cell.kids = static_cast<uint8_t>(children);
    const Sight s = sightOf(c, cell.height, radiusOf(depth));
    cell.side = static_cast<uint8_t>(s.side);
    cell.shrink = static_cast<uint8_t>(s.shrink);
    const int kids = children == 0 ? 0 : children < 3 ? 1 : children == 3 ? 2 : 3;
    const size_t at = (((static_cast<size_t>(kids) * DeltaModel::kSides + static_cast<size_t>(s.side)) * 4 +
                        static_cast<size_t>(s.side_before)) *
                           DeltaModel::kShrink +
                       static_cast<size_t>(s.shrink)) *
                          4 +
                      cell.near;
    return code(model_.alive[at], kEncodes && isAlive(depth, cell));
  }

  bool codeGoes(NodeId n, Slot slot, size_t kind, const Cell& cell) {
    const size_t kids = cell.kids == 0 ? 0 : cell.kids < 3 ? 1 : 2;
    const size_t at = ((kind * 3 + kids) * DeltaModel::kSides + cell.side) * 4 + cell.shrink / 2;
    if (!code(model_.goes[at], kEncodes && !held_.has(slot))) return false;
    goAll(n, slot);
    return true;
  }

  // The node goes, and with it what stands on it.
  void goAll(NodeId n, Slot slot) {
    stack_.push_back(n);
    markGone(slot);
    while (!stack_.empty()) {
      const NodeId top = stack_.back();
      stack_.pop_back();
      for (NodeId child : grid_.children(top)) {
        const Slot at = grid_.slot(child);
        if (const auto* change = changes_.find(at); change && change->known) continue;
        if (!wasThere(at)) continue;
        markGone(at);
        stack_.push_back(child);
      }
    }
  }
  void markGone(Slot slot) {
    if constexpr (kEncodes) {
      changes_.find(slot)->known = true;
    } else {
      auto& change = changes_.insert(slot);
      change.known = true;
      change.comes = false;
      change.height = 0;
      removed.push_back(slot);
    }
  }

  bool codeComes(NodeId n, Slot slot, size_t kind) {
    const auto [a, b] = grid_.endpoints(n);
    const int32_t ha = heightOf(a), hb = heightOf(b);
    const int32_t middle = (ha + hb) >> 1;
    int64_t expected = 0, apex_sum = 0;
    int apex_count = 0;
    bool fresh = !model_.has_view;
    for (NodeId p : grid_.apexes(n)) {
      const bool base = grid_.isBase(p);
      if (!base && !fresh) fresh = !wasThere(grid_.slot(p));
      expected += std::abs(int64_t{displacementOf(p)});
      apex_sum += heightOf(p);
      ++apex_count;
    }
    if (apex_count == 1) expected *= 2, apex_sum *= 2;
    const int64_t twist = (apex_sum - ha - hb) / 2;
    const double radius = spacing_m_ * static_cast<double>(1u << grid_.scaleLog2(n));
    const glm::dvec3 p = frame_.position(n, middle);
    const Eye::Place place = now_.at(p);
    const int side = binOf(place.side / radius, kSideEdges, 7);
    const double depth = std::max(place.depth, 1.0);
    const int64_t expected_steps = expected + 1 + std::abs(twist) / 2;
    const double error_px = static_cast<double>(expected_steps) * 0.5 * step_m_ * focal_over_tau_ / depth;
    const int size = std::clamp(halfOctaves(error_px) + 6, 0, 15);
    AdaptiveBit* bit;
    if (fresh) {
      const int scale = std::min<int>(static_cast<int>(grid_.scaleLog2(n)), 7);
      bit =
          &model_.comes[((kind * 16 + static_cast<size_t>(size)) * DeltaModel::kSides + static_cast<size_t>(side)) * 8 +
                        static_cast<size_t>(scale)];
    } else {
      const Eye::Place b4 = before_.at(p);
      const int shrink = binOf((b4.depth - place.depth) / depth, kShrinkEdges, 7);
      const int before = binOf(b4.side / radius, kSideEdges + 2, 3);
      bit = &model_.comes_later
                 [(((kind * DeltaModel::kShrink + static_cast<size_t>(shrink)) * 4 + static_cast<size_t>(before)) * 16 +
                   static_cast<size_t>(size)) *
                      4 +
                  static_cast<size_t>(side / 2)];
    }
    if (!code(*bit, kEncodes && held_.has(slot))) return false;
    codeHeight(n, slot, middle, expected, twist);
    return !failed_;
  }

  void codeHeight(NodeId n, Slot slot, int32_t middle, int64_t expected, int64_t twist) {
    double before = 0;
    if constexpr (kEncodes) before = bits_ ? coder_.bits() : 0;
    const int32_t unit = static_cast<int32_t>(model_.unit);
    const int32_t base = floorDiv(middle + unit / 2, unit);
    const int magnitude =
        std::min(std::max(0, halfOctaves(static_cast<double>(expected + std::abs(twist) + 1) / unit) + 2),
                 DeltaModel::kMagnitudes - 1);
    const int lean = std::abs(twist) * 4 < expected ? 0 : twist < 0 ? 1 : 2;
    int32_t r = 0, rest = 0;
    if constexpr (kEncodes) {
      const int32_t wanted = held_.height(n), multiple = floorDiv(wanted, unit);
      r = multiple - base;
      rest = wanted - multiple * unit;
    }
    r = codeResidual(r, static_cast<size_t>(magnitude), static_cast<size_t>(lean));
    if (unit > 1) {
      if (!code(model_.off_unit, rest != 0))
        rest = 0;
      else
        rest = static_cast<int32_t>(
            coder_.codeEvenly(static_cast<uint32_t>(rest), std::bit_width(static_cast<uint32_t>(unit - 1))));
    }
    const int64_t height = (int64_t{base} + r) * unit + rest;
    if (height < -kMaxHeight || height > kMaxHeight) failed_ = true;
    if constexpr (kEncodes) {
      if (bits_) bits_->heights += coder_.bits() - before;
      auto* change = changes_.find(slot);
      change->known = true;
      change->height = static_cast<int32_t>(height);
      change->displacement = static_cast<int32_t>(height) - middle;
    } else {
      if (added.size() >= most_nodes_ || coder_.overrun()) failed_ = true;
      if (failed_) return;
      auto& change = changes_.insert(slot);
      change = {slot, true, true, static_cast<int32_t>(height), static_cast<int32_t>(height) - middle};
      added.push_back({slot, static_cast<int32_t>(height)});
    }
  }

  static int32_t floorDiv(int32_t a, int32_t b) { return a / b - (a % b < 0 ? 1 : 0); }

  int32_t codeResidual(int32_t r, size_t magnitude, size_t lean) {
    const uint32_t m = static_cast<uint32_t>(std::abs(r));
    int e = std::min(static_cast<int>(std::bit_width(m)), 31);
    // The number of significant bits, as a tree of four decisions; 15 escapes.
    auto& tree = model_.exponent[magnitude * 3 + (lean + 1) / 2];
    size_t at = 1;
    const int low = std::min(e, 15);
    for (int i = 3; i >= 0; --i) at = 2 * at + (code(tree[at], low >> i & 1) ? 1 : 0);
    int got = static_cast<int>(at) - 16;
    if (got == 15)
      while (got < 31 && code(model_.escape[static_cast<size_t>(got)], e > got)) ++got;
    e = got;
    if (e == 0) return 0;
    const bool negative = code(model_.sign[lean * 4 + static_cast<size_t>(std::min(e - 1, 3))], r < 0);
    uint32_t value = 1;
    int left = e - 1;
    if (left > 0) {
      const bool top = code(model_.mantissa[static_cast<size_t>(e)][0], m >> (left - 1) & 1);
      value = 2 * value + (top ? 1 : 0);
      --left;
      if (left > 0) {
        value =
            2 * value + (code(model_.mantissa[static_cast<size_t>(e)][1 + (top ? 1 : 0)], m >> (left - 1) & 1) ? 1 : 0);
        --left;
      }
    }
    while (left > 0) {
      const int take = std::min(left, 12);
      left -= take;
      value = value << take | coder_.codeEvenly(m >> left & ((1u << take) - 1), take);
    }
    return negative ? -static_cast<int32_t>(value) : static_cast<int32_t>(value);
  }

  const GridTopology& grid_;
  const FrameGrid& frame_;
  const HeldNodes& held_;
  DeltaModel& model_;
  ChangeTable& changes_;
  Coder& coder_;
  size_t most_nodes_;
  DeltaBits* bits_;
  Eye now_, before_;
  int k_;
  double step_m_, spacing_m_, focal_over_tau_;
  std::vector<NodeId> stack_;
  bool failed_ = false;
};

// The cells that hold an explicit change, and all cells around them, by depth.
std::vector<std::vector<uint64_t>> aliveCells(const GridTopology& grid, const CutDelta& cut, const HeldNodes& held) {
  const int k = static_cast<int>(grid.shape().root_log2);
  std::vector<std::vector<uint64_t>> cells(static_cast<size_t>(k));
  const auto mark = [&](NodeId n) {
    const uint32_t t = grid.scaleLog2(n);
    cells[static_cast<size_t>(k - 1) - t].push_back(uint64_t{n.y() >> (t + 1)} << 32 | n.x() >> (t + 1));
  };
  for (Slot slot : cut.added) mark(grid.node(slot));
  for (Slot slot : cut.removed) {
    const NodeId n = grid.node(slot);
    bool told = true;
    for (NodeId p : grid.parents(n)) told = told && held.has(grid.slot(p));
    if (told) mark(n);
  }
  for (int depth = k - 1; depth >= 0; --depth) {
    auto& keys = cells[static_cast<size_t>(depth)];
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    if (depth == 0) break;
    for (uint64_t key : keys)
      cells[static_cast<size_t>(depth - 1)].push_back((key >> 33) << 32 | (key & 0xffffffffu) >> 1);
  }
  return cells;
}

// Heights that are nearly all multiples of a unit (whole metres in a scene of decimetres) are coded as multiples, the
// rest apart.
constexpr uint32_t kUnits[] = {1, 2, 5, 10, 20, 50, 100, 1000};

template <class Coder>
void codeUnit(Coder& coder, DeltaModel& model, uint32_t choice) {
  if (coder.code(model.unit_changes, kUnits[choice] != model.unit)) model.unit = kUnits[coder.codeEvenly(choice, 3)];
}

// The largest unit that seven of eight heights are multiples of.
uint32_t chooseUnit(const GridTopology& grid, const CutDelta& cut, const HeldNodes& held, uint32_t last) {
  constexpr size_t kFew = 64;
  for (uint32_t choice = 7; choice > 0; --choice) {
    if (cut.added.size() < kFew && kUnits[choice] == last) return choice;
    size_t multiples = 0;
    for (size_t i = 0; i < cut.added.size() && multiples * 8 + kFew >= i * 7; ++i)
      multiples += held.height(grid.node(cut.added[i])) % static_cast<int32_t>(kUnits[choice]) == 0 ? 1 : 0;
    if (cut.added.size() >= kFew && multiples * 8 >= cut.added.size() * 7) return choice;
  }
  return 0;
}

}  // namespace

void encodeDelta(const GridTopology& grid, const FrameGrid& frame, const CutDelta& cut, const DeltaView& view,
                 const HeldNodes& held, DeltaModel& model, Bytes& out, DeltaBits* bits) {
  ChangeTable changes(cut.added.size() + cut.removed.size());
  for (Slot slot : cut.added) changes.insert(slot).comes = true;
  for (Slot slot : cut.removed) changes.insert(slot);
  RangeEncoder coder(out);
  codeUnit(coder, model, chooseUnit(grid, cut, held, model.unit));
  Traversal<RangeEncoder> traversal(grid, frame, view, held, model, changes, coder, cut.added.size(), bits);
  traversal.alive_cells = aliveCells(grid, cut, held);
  traversal.run();
  const double all = coder.bits();
  coder.finish();
  if (bits) bits->structure = all - bits->heights;
  model.has_view = true;
  model.view = view;
}

Status decodeDelta(const GridTopology& grid, const FrameGrid& frame, ByteSpan bytes, const DeltaView& view,
                   const HeldNodes& held, DeltaModel& model, HeightDelta& out) {
  const auto malformed = [](const char* what) {
    return Error{ErrorCode::kMalformed, std::string("cut delta: ") + what};
  };
  const size_t most_nodes = std::min(kMaxDeltaNodes, kNodesPerByte * bytes.size() + kNodesPerByte);
  ChangeTable changes(512);
  RangeDecoder coder(bytes);
  codeUnit(coder, model, 0);
  Traversal<RangeDecoder> traversal(grid, frame, view, held, model, changes, coder, most_nodes, nullptr);
  if (!traversal.run()) return malformed("more nodes than bytes, or an absurd height");
  if (!coder.atEnd()) return malformed("cut short, or bytes left over");
  std::sort(traversal.added.begin(), traversal.added.end(),
            [](const Added& a, const Added& b) { return a.slot < b.slot; });
  std::sort(traversal.removed.begin(), traversal.removed.end());
  out.cut.removed = std::move(traversal.removed);
  out.cut.added.clear();
  out.heights.clear();
  for (const Added& a : traversal.added) {
    out.cut.added.push_back(a.slot);
    out.heights.push_back(a.height);
  }
  model.has_view = true;
  model.view = view;
  return {};
}

}  // namespace foreland::proto
