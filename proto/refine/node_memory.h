// What both ends remember of nodes that were sent, page by page, while the page has no node in the section or on its
// frontier: which of its nodes the client knows, with their heights and errors, and what else was said of the page.
// When nodes of the page come to the frontier again, none of it is said again.
//
// Both ends do the same at the same steps, so nothing is said about what is forgotten, either. Pages that have been
// away longest go first once what the client needs for all of them exceeds a budget, which is what the client says that
// it can spare. The client has the records themselves elsewhere (client/mesh/held_nodes.h).
//
// One owner. O(1) for each page; 48 bytes a page and its cells of an index.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/check.h"
#include "proto/refine/slot_bits.h"
#include "proto/section/bounds.h"
#include "proto/section/index_table.h"
#include "proto/topology/node.h"

namespace foreland::proto {

// What was said of a page's nodes.
struct PageKnowledge {
  SlotBits known;              // nodes whose height was sent
  SlotBits settled;            // those whose error follows from decisions
  QuantisedRadius radius;      // of all nodes of the page
  QuantisedError finest{255};  // the least error that a node of the page was asked about

  // Whether any of the 64 slots from `first` on is known, a multiple of 64.
  bool knowsAnyOf64(Slot first) const { return known.words[first % kPageSlots / 64] != 0; }
  // What the client spends on the known nodes: records in blocks of 64, and the page.
  size_t clientBytes() const {
    size_t blocks = 0;
    for (uint64_t word : known.words) blocks += word != 0 ? 1 : 0;
    return kPageBytes + blocks * kBlockBytes;
  }
  static constexpr size_t kPageBytes = 128, kBlockBytes = 512;
  bool operator==(const PageKnowledge&) const = default;
};

// What both ends go on remembering when they start from the empty section again.
enum class Remembered : uint8_t { kNothing, kPages };

struct KnownPage {
  Slot first = 0;
  PageKnowledge knowledge;
  bool operator==(const KnownPage&) const = default;
};

class NodeMemory {
 public:
  // Of what clientBytes() adds up to.
  void setBudget(uint64_t bytes) {
    budget_ = bytes;
    evict();
  }
  uint64_t budget() const { return budget_; }

  // Remembers a page as the one that was used last; it must not be remembered yet.
  void keep(Slot first, const PageKnowledge& knowledge);
  // What is remembered of the slot's page, if anything, and forgets it: it is in use again.
  std::optional<PageKnowledge> take(Slot slot);

  // The same without forgetting it; null if nothing is.
  const PageKnowledge* find(Slot slot) const {
    const uint32_t at = index_.find(slot / kPageSlots);
    return at == IndexTable::kNone ? nullptr : &pages_[at].knowledge;
  }
  // Calls visit(first slot, knowledge) for each page, the one that was used last first.
  template <class Visit>
  void forEach(const Visit& visit) const {
    for (uint32_t at = pages_[kEnds].older; at != kEnds; at = pages_[at].older)
      visit(Slot{pages_[at].key} * kPageSlots, pages_[at].knowledge);
  }

  uint64_t clientBytes() const { return client_bytes_; }
  size_t pageCount() const { return index_.size(); }
  size_t knownCount() const { return known_; }  // nodes
  // Forgets all pages.
  void clear();
  size_t bytes() const { return pages_.capacity() * sizeof(Page) + index_.bytes(); }

 private:
  static constexpr uint32_t kEnds = IndexTable::kNone;  // pages_[0]: of a ring, between the newest and the oldest
  struct Page {
    uint32_t key = 0, older = kEnds, newer = kEnds;
    PageKnowledge knowledge;
  };
  void evict();
  void unlink(uint32_t at);

  uint64_t budget_ = 0, client_bytes_ = 0;
  size_t known_ = 0;
  std::vector<Page> pages_ = std::vector<Page>(1);  // the first knows nothing
  std::vector<uint32_t> free_;
  IndexTable index_;  // by slot / kPageSlots
};

}  // namespace foreland::proto
