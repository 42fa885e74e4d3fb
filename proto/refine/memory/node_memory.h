// What both ends remember of nodes that were sent, page by page, while the page has no node in the section or on its
// frontier: which of its nodes the client knows, with their heights and errors, and what else was said of the page.
// When nodes of the page come to the frontier again, none of it is said again.
//
// Both ends do the same at the same steps, so nothing is said about what is forgotten, either. Pages that have been
// away longest go first once what the client needs for all of them exceeds a budget, which is what the client says that
// it can spare. The client has the records themselves elsewhere (client/mesh/terrain/held_nodes.h).
//
// A log of packed pages (page_knowledge.h) in the order of their last use, and an index of where in the log a page
// stands: what was taken from the log stays there, unused, until an eighth of it is, and then what is used moves up.
// One owner. O(1) for each page; some 40 bytes a page.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/bytes.h"
#include "proto/refine/memory/page_knowledge.h"

namespace foreland::proto {

// What both ends go on remembering when they start from the empty section again.
enum class Remembered : uint8_t { kNothing, kPages };

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
  // The same without forgetting it.
  std::optional<PageKnowledge> find(Slot slot) const;
  // Parts of it, for less: O(1).
  std::optional<QuantisedRadius> radius(Slot slot) const;
  // Whether any of the 64 slots from `first` on is remembered as known, a multiple of 64.
  bool knowsAnyOf64(Slot first) const;

  // All pages, the one that was used last first. O(pages).
  std::vector<KnownPage> pages() const;

  uint64_t clientBytes() const { return client_bytes_; }
  size_t pageCount() const { return count_; }
  size_t knownCount() const { return known_; }  // nodes
  // Forgets all pages.
  void clear();
  size_t bytes() const { return log_.capacity() + cells_.capacity() * sizeof(Place); }

 private:
  // Where a page's entry begins in the log.
  using Place = uint32_t;
  static constexpr Place kNowhere = ~Place{0};
  struct Entry {
    uint64_t key;  // slot / kPageSlots
    ByteSpan packed;
    size_t size() const { return 1 + keyBytes(key) + packed.size(); }
  };
  // Before what is packed: how many bytes of it follow, with a flag if the key is a long one; and the key.
  static constexpr uint8_t kLong = 0x80;
  static constexpr size_t keyBytes(uint64_t key) { return key >> 24 == 0 ? 3 : 6; }

  Entry entryAt(Place place) const;
  std::optional<Entry> entryOf(Slot slot) const;
  bool isUsed(uint64_t key, Place place) const;
  void remove(size_t cell, const Entry& entry, const PageKnowledge& knowledge);
  void evict();
  void moveUp();

  // The index: open addressing with linear probing, a cell for each page that names its place only; the key stands in
  // the log. At most three of four cells are used.
  size_t home(uint64_t key) const { return ((key * 0x9e3779b97f4a7c15u >> 32) * cells_.size()) >> 32; }
  size_t next(size_t cell) const { return cell + 1 == cells_.size() ? 0 : cell + 1; }
  // The cell of the key, or the free one where it would be. There are cells.
  size_t cellOf(uint64_t key) const;
  void makeCells(size_t count);
  void freeCell(size_t cell);

  uint64_t budget_ = 0, client_bytes_ = 0;
  size_t count_ = 0, known_ = 0;
  size_t unused_ = 0;  // bytes of the log
  Place oldest_ = 0;   // nothing before it is used
  Bytes log_;
  std::vector<Place> cells_;
};

}  // namespace foreland::proto
