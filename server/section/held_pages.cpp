#include "server/section/held_pages.h"

#include <algorithm>
#include <array>
#include <limits>

#include "server/section/budget.h"

namespace foreland::server {

using proto::NodeId;
using proto::Slot;
using terrain::ChunkCache;

// Reads what is there, and notes what is not.
class HeldPages::Lacking final : public proto::ReadableNodes {
 public:
  explicit Lacking(HeldPages& pages) : pages_(pages) {}
  bool isReadable(Slot slot) override {
    const bool is_readable = pages_.need(slot);
    if (!is_readable) slots_.push_back(slot);
    return is_readable;
  }
  const std::vector<Slot>& slots() const { return slots_; }

 private:
  HeldPages& pages_;
  std::vector<Slot> slots_;
};

HeldPages::HeldPages(const Hierarchy& hierarchy)
    : hierarchy_(hierarchy),
      cache_(hierarchy.scene().supply()->cache()),
      place_count_(hierarchy.scene().records().size()),
      wishes_(cache_) {}

HeldPages::~HeldPages() {
  for (const auto& [chunk, keyframe] : held_) cache_.release(chunk);
}

bool HeldPages::isReadable(Slot slot) { return hold(slot, kMeasured, last_measured_); }

bool HeldPages::need(Slot slot) { return hold(slot, keyframe_, last_needed_); }

// `last_page` is one that is held for this already.
bool HeldPages::hold(Slot slot, uint32_t keyframe, uint64_t& last_page) {
  const uint64_t page = slot / proto::kPageSlots;
  if (page == last_page) return true;
  const uint64_t place = hierarchy_.scene().pages().placeOf(slot);
  if (place < place_count_) {
    const ChunkCache::Chunk chunk = hierarchy_.scene().supply()->chunkOf(place);
    if (const auto held = held_.find(chunk); held != held_.end())
      held->second = std::max(held->second, keyframe);
    else if (cache_.hold(chunk))
      held_.emplace(chunk, keyframe);
    else
      return false;
  }
  last_page = page;
  return true;
}

void HeldPages::releaseThose(bool (*which)(uint32_t needed, uint32_t keyframe)) {
  std::erase_if(held_, [&](const auto& each) {
    if (!which(each.second, keyframe_)) return false;
    cache_.release(each.first);
    return true;
  });
}

// A node comes to the frontier when all of its parents are in the section. So the section must be without one of those
// of a node that lacks, and the coarsest tolerance that still has it is the error of the parent with the smallest one.
void HeldPages::addWishes(const Lacking& lacking, const proto::View& view, float share, std::vector<Wish>& wishes,
                          double& tolerance) {
  constexpr double kRounding = 1.0001;  // of tests in single precision, and of the tolerance to a float
  const proto::Metric metric = hierarchy_.domain().metric(view);
  const proto::StoredNodes nodes = hierarchy_.nodes();
  const proto::GridTopology& grid = hierarchy_.grid();
  std::unordered_map<ChunkCache::Chunk, float> errors;
  std::array<Slot, proto::TerrainBatch::kSize> child;
  const auto finish = [&] {
    batch_.locate(hierarchy_.domain(), metric);
    for (size_t i = 0; i < batch_.count;) {
      const Slot slot = child[i];
      double error_px = std::numeric_limits<double>::infinity();
      for (; i < batch_.count && child[i] == slot; ++i) {
        const double least = batch_.leastError(i, metric), own = batch_.bound[i].metres();
        error_px = std::min(error_px, least > 0 ? view.tau_px * own / least : double{kMaxTolerance_px});
      }
      if (error_px * kRounding < view.tau_px) continue;
      tolerance = std::max(tolerance, error_px * kRounding);
      float& most = errors[hierarchy_.scene().supply()->chunkOf(hierarchy_.scene().pages().placeOf(slot))];
      most = std::max(most, share * static_cast<float>(error_px));
    }
    batch_.count = 0;
  };
  batch_.count = 0;
  for (const Slot slot : lacking.slots()) {
    constexpr size_t kMostParents = 4;
    if (batch_.count + kMostParents > proto::TerrainBatch::kSize) finish();
    const NodeId n = grid.node(slot);
    const int level = grid.level(n);
    for (const NodeId parent : grid.parents(n, level)) {
      const Slot of_parent = grid.slot(parent, level - 1);
      if (!need(of_parent)) continue;  // what it lacks itself keeps it out of the section
      const proto::NodeRecord& record = nodes[of_parent];
      child[batch_.count] = slot;
      batch_.setRecord(batch_.count, record);
      batch_.push(parent, of_parent, level - 1, record.error(), hierarchy_.domain().radius(level - 1, record.radius()));
    }
  }
  finish();
  tolerance = std::min(tolerance, double{kMaxTolerance_px});
  for (const auto& [chunk, error_px] : errors) wishes.push_back({chunk, error_px});
}

double HeldPages::tolerance(const proto::View& view, proto::RefineScratch& scratch, proto::Section& section) {
  proto::View aimed = view;
  aimed.tau_px = std::max<double>(view.tau_px, static_cast<float>(aim_px_));
  Lacking lacking(*this);
  (void)refine(hierarchy_, aimed, std::numeric_limits<size_t>::max(), scratch, section, nullptr, &lacking);
  double tolerance = aimed.tau_px;
  now_.clear();
  addWishes(lacking, aimed, 1, now_, tolerance);
  is_lacking_ = tolerance > view.tau_px;
  releaseThose([](uint32_t needed, uint32_t) { return needed == kMeasured; });
  last_measured_ = kNoPage;
  aim(view.tau_px);
  tell();
  return tolerance;
}

// For the next keyframe. After a jump what the last view needed is still held, so one keyframe says nothing.
void HeldPages::aim(double wanted_px) {
  constexpr double kRaise = 1.2, kLower = 1.08, kRoomy = 0.9;
  constexpr int kFullFor = 2;
  const auto [held, capacity] = cache_.use();
  full_in_a_row_ = now_.size() + held > capacity ? full_in_a_row_ + 1 : 0;
  if (full_in_a_row_ >= kFullFor) aim_px_ = std::max(aim_px_, wanted_px) * kRaise;
  if (now_.empty() && static_cast<double>(held) < kRoomy * static_cast<double>(capacity)) aim_px_ /= kLower;
  if (aim_px_ <= wanted_px) aim_px_ = 0;
}

void HeldPages::expect(const proto::View& view, size_t max_nodes, proto::RefineScratch& scratch,
                       proto::Section& section) {
  constexpr float kOfNow = 0.25F;
  Lacking lacking(*this);
  (void)refine(hierarchy_, view, max_nodes, scratch, section, nullptr, &lacking);
  double tolerance = view.tau_px;
  later_.clear();
  addWishes(lacking, view, kOfNow, later_, tolerance);
  tell();
}

void HeldPages::expectTiles(std::vector<Wish> wishes) {
  tiles_ = std::move(wishes);
  tell();
}

void HeldPages::tell() {
  std::vector<Wish> all = now_;
  all.insert(all.end(), later_.begin(), later_.end());
  all.insert(all.end(), tiles_.begin(), tiles_.end());
  wishes_.set(std::move(all));
}

void HeldPages::endKeyframe() {
  releaseThose([](uint32_t needed, uint32_t keyframe) { return needed != keyframe; });
  ++keyframe_;
  last_needed_ = last_measured_ = kNoPage;
}

}  // namespace foreland::server
