#include "proto/refine/node_memory.h"

namespace foreland::proto {

void NodeMemory::keep(Slot first, const PageKnowledge& knowledge) {
  if (budget_ == 0) return;
  const uint32_t key = first / kPageSlots;
  if (free_.empty()) {
    if (pages_.size() == pages_.capacity()) pages_.reserve(pages_.size() + 64 + pages_.size() / 8);
    free_.push_back(static_cast<uint32_t>(pages_.size()));
    pages_.emplace_back();
  }
  const uint32_t at = free_.back();
  free_.pop_back();
  index_.insert(key, at);
  const uint32_t newest = pages_[kEnds].older;
  pages_[at] = {key, newest, kEnds, knowledge};
  pages_[newest].newer = at;
  pages_[kEnds].older = at;
  client_bytes_ += knowledge.clientBytes();
  known_ += knowledge.known.count();
  evict();
}

std::optional<PageKnowledge> NodeMemory::take(Slot slot) {
  const uint32_t at = index_.find(slot / kPageSlots);
  if (at == IndexTable::kNone) return std::nullopt;
  unlink(at);
  return pages_[at].knowledge;
}

void NodeMemory::clear() {
  const uint64_t budget = budget_;
  *this = {};
  budget_ = budget;
}

void NodeMemory::unlink(uint32_t at) {
  const Page& page = pages_[at];
  pages_[page.older].newer = page.newer;
  pages_[page.newer].older = page.older;
  index_.erase(page.key);
  free_.push_back(at);
  client_bytes_ -= page.knowledge.clientBytes();
  known_ -= page.knowledge.known.count();
}

void NodeMemory::evict() {
  while (client_bytes_ > budget_) unlink(pages_[kEnds].newer);
}

}  // namespace foreland::proto
