#include "lab/occlusion/possible.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <unordered_set>

#include "proto/refine/hidden/hidden_blocks.h"
#include "terrain/parallel.h"

namespace foreland::lab {

namespace {

using proto::NodeId;
using proto::Slot;

constexpr double kConeMargin_rad = 0.2;  // a region turns by less between two keyframes, but for `spin`

double metresOf(const glm::dvec3& point, const glm::dvec3& eye, const proto::Lens& lens, double px) {
  return px * glm::distance(point, eye) / lens.focalPx();
}

// A square about a node with all supports of its descendants, cut off at the grid's borders.
struct Square {
  int64_t low_x, low_y, high_x, high_y;
};

Square supportsOf(const proto::GridTopology& grid, NodeId n) {
  const int64_t s = int64_t{1} << grid.scaleLog2(n);
  const bool is_centre = (n.x() & n.y() & static_cast<uint32_t>(s)) != 0;
  const int64_t r = (is_centre ? 3 : 2) * s, x = n.x(), y = n.y();
  return {std::max<int64_t>(0, x - r), std::max<int64_t>(0, y - r), std::min<int64_t>(grid.maxX(), x + r),
          std::min<int64_t>(grid.maxY(), y + r)};
}

// The blocks of the node's scale that its square does more than touch.
Square blocksOf(const proto::GridTopology& grid, NodeId n) {
  const Square q = supportsOf(grid, n);
  const int64_t side = int64_t{proto::BlockId::kSide} << grid.scaleLog2(n);
  const auto down = [&](int64_t v) { return v / side * side; };
  const auto up = [&](int64_t v) { return (v + side - 1) / side * side; };
  return {down(q.low_x), down(q.low_y), up(q.high_x), up(q.high_y)};
}

}  // namespace

void PossibleNodes::add(const PossibleNodes& other) {
  all += other.all;
  visible += other.visible;
  vertices += other.vertices;
  raised += other.raised;
  supports += other.supports;
  blocks += other.blocks;
  region += other.region;
}

VisibleSamples::VisibleSamples(const oracle::LineOfSight& terrain)
    : terrain_(terrain), is_visible_(size_t{terrain.shape().samples_x} * terrain.shape().samples_y) {}

void VisibleSamples::see(const proto::Pose& pose, const proto::Lens& lens, double raised_px) {
  const double up = lens.tanHalfFov(), aside = up * lens.width_px / lens.height_px,
               min_cosine = std::cos(std::min(3.1, std::atan(std::hypot(up, aside)) + kConeMargin_rad));
  const uint32_t columns = terrain_.shape().samples_x;
  terrain::parallelFor(
      terrain_.shape().samples_y, 0,
      [&](uint64_t row, unsigned) {
        for (uint32_t x = 0; x < columns; ++x) {
          uint8_t& seen = is_visible_[row * columns + x];
          if (seen != 0) continue;
          glm::dvec3 point = terrain_.pointAt({x, static_cast<double>(row)});
          const glm::dvec3 ahead = point - pose.eye;
          if (glm::dot(ahead, pose.forward()) < min_cosine * glm::length(ahead)) continue;
          point += metresOf(point, pose.eye, lens, raised_px) * terrain_.upAt(point);
          seen = terrain_.isClear(point, pose.eye) ? 1 : 0;
        }
      },
      [](uint64_t) { return true; });
}

void VisibleSamples::sum() {
  const size_t columns = terrain_.shape().samples_x, rows = terrain_.shape().samples_y;
  sums_.assign((columns + 1) * (rows + 1), 0);
  for (size_t y = 0; y < rows; ++y) {
    uint32_t row = 0;
    for (size_t x = 0; x < columns; ++x) {
      row += is_visible_[y * columns + x];
      sums_[(y + 1) * (columns + 1) + x + 1] = sums_[y * (columns + 1) + x + 1] + row;
    }
  }
}

uint32_t VisibleSamples::upTo(int64_t x, int64_t y) const {
  const int64_t columns = terrain_.shape().samples_x, rows = terrain_.shape().samples_y;
  const auto i = static_cast<size_t>(std::clamp<int64_t>(x, 0, columns)),
             j = static_cast<size_t>(std::clamp<int64_t>(y, 0, rows));
  return sums_[j * (static_cast<size_t>(columns) + 1) + i];
}

bool VisibleSamples::any(int64_t low_x, int64_t low_y, int64_t high_x, int64_t high_y) const {
  return upTo(high_x + 1, high_y + 1) + upTo(low_x, low_y) > upTo(low_x, high_y + 1) + upTo(high_x + 1, low_y);
}

glm::dvec3 PossibleJudge::vertex(Slot slot) const {
  return hierarchy_.frame().position(grid().node(slot), hierarchy_.nodes()[slot].height());
}

std::vector<Slot> PossibleJudge::visible(const std::vector<Slot>& slots, const glm::dvec3& eye, const proto::Lens& lens,
                                         double raised_px) const {
  constexpr size_t kPiece = 1024;
  const proto::GridShape& shape = grid().shape();
  const auto isVisible = [&](Slot slot) {
    const NodeId n = grid().node(slot);
    if (n.x() >= shape.samples_x || n.y() >= shape.samples_y) return false;
    glm::dvec3 point = vertex(slot);
    point += metresOf(point, eye, lens, raised_px) * terrain_.upAt(point);
    return terrain_.isClear(point, eye);
  };
  std::vector<uint8_t> is_visible(slots.size());
  terrain::parallelFor((slots.size() + kPiece - 1) / kPiece, 0,
                       [&](uint64_t piece, unsigned) {
                         const size_t end = std::min(slots.size(), (piece + 1) * kPiece);
                         for (size_t i = piece * kPiece; i < end; ++i) is_visible[i] = isVisible(slots[i]) ? 1 : 0;
                       },
                       [](uint64_t) { return true; });
  std::vector<Slot> out;
  for (size_t i = 0; i < slots.size(); ++i)
    if (is_visible[i] != 0) out.push_back(slots[i]);
  return out;
}

double PossibleJudge::withAncestors(const std::vector<Slot>& slots) const {
  std::unordered_set<Slot> closure;
  std::vector<Slot> open = slots;
  while (!open.empty()) {
    const Slot slot = open.back();
    open.pop_back();
    if (!closure.insert(slot).second) continue;
    for (NodeId parent : grid().parents(grid().node(slot))) open.push_back(grid().slot(parent));
  }
  return static_cast<double>(closure.size());
}

PossibleNodes PossibleJudge::count(const std::vector<Slot>& slots, const EyesOfKeyframe& eyes, const proto::Lens& lens,
                                   double tau_px) const {
  PossibleNodes counts;
  const std::vector<Slot> seen = visible(slots, eyes.now.eye, lens, 0);
  counts.all = static_cast<double>(slots.size());
  counts.visible = static_cast<double>(seen.size());
  counts.vertices = withAncestors(seen);
  counts.raised = withAncestors(visible(slots, eyes.now.eye, lens, tau_px));

  VisibleSamples samples(terrain_);
  // What is visible in a node's descendants' supports is so in its own: ancestors are there already.
  const auto countWhere = [&](Square (*square)(const proto::GridTopology&, NodeId)) {
    samples.sum();
    return static_cast<double>(std::count_if(slots.begin(), slots.end(), [&](Slot slot) {
      const Square q = square(grid(), grid().node(slot));
      return samples.any(q.low_x, q.low_y, q.high_x, q.high_y);
    }));
  };
  samples.see(eyes.now, lens, tau_px);
  counts.supports = countWhere(supportsOf);
  counts.blocks = countWhere(blocksOf);
  samples.see(eyes.before, lens, tau_px);
  samples.see(eyes.after, lens, tau_px);
  counts.region = countWhere(blocksOf);
  return counts;
}

}  // namespace foreland::lab
