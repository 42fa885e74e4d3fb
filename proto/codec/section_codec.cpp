#include "proto/codec/section_codec.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/sort.h"
#include "proto/codec/range_coder.h"
#include "proto/codec/symbols.h"
#include "proto/refine/memory/paged_nodes.h"
#include "proto/refine/memory/slot_bits.h"
#include "proto/section/index_table.h"

namespace foreland::proto {

namespace {

// Some nodes of one level, by pages: those that are candidates, and those that one of two parents has made known.
class Candidates {
 public:
  struct Page {
    uint64_t key;  // slot / kPageSlots
    SlotBits candidates, half;
  };

  Candidates() { numbers_.reset(0); }
  bool empty() const { return pages_.size() == 1; }
  void clear() {
    pages_.resize(1);
    numbers_.reset(0);
  }
  void add(Slot slot) { pageOf(slot).candidates.set(lowOf(slot)); }
  // The node is a child of `parent`, which is in the section. It is a candidate once all its parents are.
  template <class Topology>
  void addChild(const Topology& topology, NodeId child, int level, NodeId parent) {
    const Slot slot = topology.slot(child, level);
    Page& page = pageOf(slot);
    const uint8_t low = lowOf(slot);
    const bool has_all = topology.hasOtherParent(child, parent, [&](NodeId) { return page.half.has(low); });
    (has_all ? page.candidates : page.half).set(low);
  }
  // Ascending from now on, until one is added.
  std::span<const Page> sorted() {
    foreland::sort(pages_.begin() + 1, pages_.end(), [](const Page& a, const Page& b) { return a.key < b.key; });
    return std::span(pages_).subspan(1);
  }

 private:
  // Neighbours mostly are in the page of the last one.
  Page& pageOf(Slot slot) {
    const uint64_t key = slot / kPageSlots;
    if (pages_[last_].key == key && last_ != IndexTable::kNone) return pages_[last_];
    last_ = numbers_.find(key);
    if (last_ == IndexTable::kNone) {
      last_ = static_cast<uint32_t>(pages_.size());
      pages_.push_back({key, {}, {}});
      numbers_.insert(key, last_);
    }
    return pages_[last_];
  }

  std::vector<Page> pages_{1};  // the first stands for none
  IndexTable numbers_;
  uint32_t last_ = IndexTable::kNone;
};

int wholeLevels(const GridTopology& grid) { return grid.wholeLevels(); }
int wholeLevels(const MeshTopology& mesh) { return mesh.maxLevel(); }

// Visits the candidates of each level, ascending; `decide(slot, context)` says which are in the section: 1, 0, or less
// to stop. On sparse levels `decidePage(first slot, candidates)` says first whether any of a page's may be. False if it
// stopped.
template <class Topology, class DecidePage, class Decide>
bool descend(const Topology& topology, Section& section, const DecidePage& decidePage, const Decide& decide) {
  Candidates candidates, next;
  for (Slot slot = topology.levelOffset(1); slot < topology.levelOffset(2); ++slot)
    if (!topology.isBase(topology.node(slot))) candidates.add(slot);
  for (int level = 1; level <= topology.maxLevel() && !candidates.empty(); ++level) {
    size_t before = 0;  // the last three bits
    const size_t first = section.slots.size();
    bool goes_on = true;
    for (const Candidates::Page& page : candidates.sorted()) {
      if (level > wholeLevels(topology) && page.candidates.any()) {
        const int any = decidePage(page.key * kPageSlots, page.candidates);
        if (any < 0) return false;
        if (any == 0) continue;
      }
      page.candidates.forEach([&](uint8_t low) {
        if (!goes_on) return;
        const Slot slot = page.key * kPageSlots + low;
        const int got = decide(slot, static_cast<size_t>(level) * 8 + before);
        goes_on = got >= 0;
        before = (2 * before + static_cast<size_t>(got)) & 7;
        if (got == 1) section.slots.push_back(slot);
      });
      if (!goes_on) return false;
    }
    next.clear();
    if (level == topology.maxLevel()) return true;
    for (size_t i = first; i < section.slots.size(); ++i) {
      const NodeId node = topology.node(section.slots[i]);
      for (NodeId child : topology.children(node, level)) next.addChild(topology, child, level + 1, node);
    }
    std::swap(candidates, next);
  }
  return true;
}

Slot firstOf(Slot slot) { return slot; }
Slot firstOf(const KnownPage& page) { return page.first; }

// Looks for slots or pages, by their first slots, among others; both ascending. Or for the first that is not before
// one.
template <class Item>
class Cursor {
 public:
  explicit Cursor(std::span<const Item> items) : items_(items) {}
  // Null if it is not among them.
  const Item* find(Slot first) {
    const Item* item = notBefore(first);
    return item && firstOf(*item) == first ? item : nullptr;
  }
  // Null if there is none.
  const Item* notBefore(Slot first) {
    while (at_ < items_.size() && firstOf(items_[at_]) < first) ++at_;
    return at_ < items_.size() ? &items_[at_] : nullptr;
  }

 private:
  std::span<const Item> items_;
  size_t at_ = 0;
};

// Of the terrain, and of all objects.
constexpr int kMaxLevels = std::max(GridTopology::kMaxLevels, MeshTopology::kMaxLevels);
struct Model {
  std::array<AdaptiveBit, 8 * (kMaxLevels + 1)> nodes;
  std::array<AdaptiveBit, 8> pages;  // by the last three
};

// Whether the next page of a sparse level has any nodes of a set, one bit each but for those that have nodes which are
// `sure` to be in the set.
template <class Coder>
class PageCoder {
 public:
  PageCoder(Coder& coder, Model& model, const Section& sure) : coder_(coder), model_(model), sure_(sure.slots) {}
  bool code(Slot first, bool has_any) {
    if (const Slot* sure = sure_.notBefore(first); sure && *sure < first + kPageSlots) return true;
    const bool got = coder_.code(model_.pages[before_], has_any);
    before_ = (2 * before_ + (got ? 1 : 0)) & 7;
    return got;
  }

 private:
  Coder& coder_;
  Model& model_;
  Cursor<Slot> sure_;
  size_t before_ = 0;
};

// Writes a closed set of nodes: those for which isIn(slot) is true and whose parents are in it; hasAny(first slot,
// candidates) says whether any of a page's candidates is. Both are asked in ascending order. Returns the set. Of nodes
// that are `sure` to be in it nothing is written.
template <class Topology, class HasAny, class IsIn>
Section encode(const Topology& topology, const HasAny& hasAny, const IsIn& isIn, const Section& sure, Model& model,
               RangeEncoder& coder) {
  Section written;
  Cursor<Slot> sure_of(sure.slots);
  PageCoder<RangeEncoder> pages(coder, model, sure);
  descend(
      topology, written,
      [&](Slot first, const SlotBits& candidates) { return pages.code(first, hasAny(first, candidates)) ? 1 : 0; },
      [&](Slot slot, size_t context) {
        return sure_of.find(slot) || coder.code(model.nodes[context], isIn(slot)) ? 1 : 0;
      });
  return written;
}
template <class Topology>
void encode(const Topology& topology, const Section& section, Model& model, RangeEncoder& coder) {
  Cursor<Slot> nodes(section.slots), pages(section.slots);
  const auto hasAny = [&](Slot first, const SlotBits&) {
    const Slot* next = pages.notBefore(first);
    return next && *next < first + kPageSlots;
  };
  encode(
      topology, hasAny, [&](Slot slot) { return nodes.find(slot) != nullptr; }, {}, model, coder);
}

// Reads one; takes its nodes, but for those that are sure, off `room`. False if there is not enough, or the bytes end.
template <class Topology>
bool decode(const Topology& topology, Section& section, const Section& sure, size_t& room, Model& model,
            RangeDecoder& coder) {
  Cursor<Slot> sure_of(sure.slots);
  PageCoder<RangeDecoder> pages(coder, model, sure);
  return descend(
      topology, section,
      [&](Slot first, const SlotBits&) { return coder.overrun()            ? -1
                                                : pages.code(first, false) ? 1
                                                                           : 0; },
      [&](Slot slot, size_t context) {
        if (sure_of.find(slot)) return 1;
        if (coder.overrun()) return -1;
        const bool is_in = coder.code(model.nodes[context]);
        if (is_in && room-- == 0) return -1;
        return is_in ? 1 : 0;
      });
}

// The pages of nodes that are known; no node was asked about.
std::vector<KnownPage> pagesOf(const Section& known) {
  std::vector<KnownPage> pages;
  for (Slot slot : known.slots) {
    const Slot first = slot / kPageSlots * kPageSlots;
    if (pages.empty() || pages.back().first != first) {
      pages.push_back({.first = first, .knowledge = {}});
      pages.back().knowledge.finest = {};
    }
    pages.back().knowledge.known.set(static_cast<uint8_t>(slot));
  }
  return pages;
}

// The least error that a node of each page was asked about, as the difference from that of the page before.
template <class Coder>
void codeFinest(std::vector<KnownPage>& pages, Coder& coder) {
  NumberModel model;
  EscapeModel escape;
  Symbols symbols(coder, escape);
  int before = QuantisedError::kZero;
  for (KnownPage& page : pages) {
    QuantisedError& finest = page.knowledge.finest;
    before = std::clamp(before + symbols.number(model, 0, finest.value - before), 0, 255);
    finest.value = static_cast<uint8_t>(before);
  }
}

}  // namespace

uint32_t fingerprint(const HeldSections& sections) {
  uint32_t sum = fingerprint(sections.terrain.slots);
  for (size_t i = 0; i < sections.objects.size(); ++i) sum += fingerprintOf(i, {sections.objects[i].slots, {}});
  return sum;
}

std::vector<KnownPage> encodeSections(const GridTopology& grid, const ObjectSet& objects, const HeldSections& sections,
                                      Bytes& out) {
  CHECK_EQ(sections.objects.size(), objects.size());
  RangeEncoder coder(out);
  Model of_terrain, of_objects, of_known;
  encode(grid, sections.terrain, of_terrain, coder);
  for (size_t i = 0; i < objects.size(); ++i)
    encode(objects.domain(i).topology(), sections.objects[i], of_objects, coder);
  Cursor<KnownPage> known(sections.known), known_pages(sections.known), given_of(sections.known);
  const auto isKnown = [&](Slot slot) {
    const KnownPage* page = known.find(slot / kPageSlots * kPageSlots);
    return page && page->knowledge.known.has(lowOf(slot));
  };
  const auto hasKnown = [&](Slot first, const SlotBits& candidates) {
    const KnownPage* page = known_pages.find(first);
    return page && (page->knowledge.known & candidates).any();
  };
  std::vector<KnownPage> pages = pagesOf(encode(grid, hasKnown, isKnown, sections.terrain, of_known, coder));
  for (KnownPage& page : pages)
    if (const KnownPage* given = given_of.find(page.first)) page.knowledge.finest = given->knowledge.finest;
  codeFinest(pages, coder);
  coder.finish();
  return pages;
}

Result<HeldSections> decodeSections(const GridTopology& grid, const ObjectSet& objects, ByteSpan bytes,
                                    const size_t max_nodes) {
  size_t room = max_nodes, room_beside = max_nodes;
  const auto malformed = [](const char* what) { return Error{ErrorCode::kMalformed, std::string("section: ") + what}; };
  RangeDecoder coder(bytes);
  Model of_terrain, of_objects, of_known;
  HeldSections sections;
  bool done = decode(grid, sections.terrain, {}, room, of_terrain, coder);
  for (size_t i = 0; done && i < objects.size(); ++i)
    done = decode(objects.domain(i).topology(), sections.objects.emplace_back(), {}, room, of_objects, coder);
  if (done) {
    Section known;
    done = decode(grid, known, sections.terrain, room_beside, of_known, coder);
    sections.known = pagesOf(known);
    codeFinest(sections.known, coder);
  }
  if (!done) return malformed("more nodes than bytes, or than are served");
  if (!coder.atEnd()) return malformed("cut short, or bytes left over");
  return sections;
}

}  // namespace foreland::proto
