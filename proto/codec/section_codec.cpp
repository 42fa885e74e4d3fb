#include "proto/codec/section_codec.h"

#include <algorithm>
#include <array>
#include <string>

#include "base/check.h"
#include "proto/codec/range_coder.h"
#include "proto/codec/symbols.h"

namespace foreland::proto {

namespace {

// Visits the candidates of each level; `answer(slot, context)` says which are in the section. False once it returns
// none.
template <class Topology, class Answer>
bool descend(const Topology& topology, Section& section, const Answer& decide) {
  std::vector<Slot> candidates, included;
  for (Slot slot = topology.levelOffset(1); slot < topology.levelOffset(2); ++slot)
    if (!topology.isBase(topology.node(slot))) candidates.push_back(slot);
  for (int level = 1; level <= topology.maxLevel() && !candidates.empty(); ++level) {
    included.clear();
    size_t before = 0;  // the last three bits
    for (Slot slot : candidates) {
      const size_t context = static_cast<size_t>(level) * 8 + before;
      const int got = decide(slot, context);
      if (got < 0) return false;
      before = (2 * before + static_cast<size_t>(got)) & 7;
      if (got == 1) included.push_back(slot);
    }
    section.slots.insert(section.slots.end(), included.begin(), included.end());
    candidates.clear();
    for (Slot slot : included)
      for (NodeId child : topology.children(topology.node(slot))) {
        const auto parents = topology.parents(child);
        // A child is found from each of its parents, and taken from the first one.
        const auto isThisOrIn = [&](NodeId n) {
          const Slot parent = topology.slot(n);
          return parent == slot || (parent > slot && std::binary_search(included.begin(), included.end(), parent));
        };
        if (std::all_of(parents.begin(), parents.end(), isThisOrIn)) candidates.push_back(topology.slot(child));
      }
    std::sort(candidates.begin(), candidates.end());
  }
  return true;
}

// Of the terrain, and of all objects.
constexpr int kMaxLevels = std::max(GridTopology::kMaxLevels, MeshTopology::kMaxLevels);
using Model = std::array<AdaptiveBit, 8 * (kMaxLevels + 1)>;

// Writes a closed set of nodes: those for which isIn(slot) is true and whose parents are in it. Returns it. Of nodes
// that are `sure` to be in it nothing is written.
template <class Topology, class IsIn>
Section encode(const Topology& topology, const IsIn& isIn, const Section& sure, Model& model, RangeEncoder& coder) {
  Section written;
  descend(topology, written, [&](Slot slot, size_t context) {
    return contains(sure, slot) || coder.code(model[context], isIn(slot)) ? 1 : 0;
  });
  return written;
}
template <class Topology>
void encode(const Topology& topology, const Section& section, Model& model, RangeEncoder& coder) {
  encode(
      topology, [&](Slot slot) { return contains(section, slot); }, {}, model, coder);
}

// Reads one; takes its nodes, but for those that are sure, off `room`. False if there is not enough, or the bytes end.
template <class Topology>
bool decode(const Topology& topology, Section& section, const Section& sure, size_t& room, Model& model,
            RangeDecoder& coder) {
  return descend(topology, section, [&](Slot slot, size_t context) {
    if (contains(sure, slot)) return 1;
    if (coder.overrun()) return -1;
    const bool is_in = coder.code(model[context]);
    if (is_in && room-- == 0) return -1;
    return is_in ? 1 : 0;
  });
}

const PageKnowledge* find(std::span<const KnownPage> pages, Slot slot) {
  const Slot first = slot / kPageSlots * kPageSlots;
  const auto at = std::lower_bound(pages.begin(), pages.end(), first,
                                   [](const KnownPage& page, Slot wanted) { return page.first < wanted; });
  return at != pages.end() && at->first == first ? &at->knowledge : nullptr;
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
  const auto isKnown = [&](Slot slot) {
    const PageKnowledge* page = find(sections.known, slot);
    return page && page->known.has(static_cast<uint8_t>(slot));
  };
  std::vector<KnownPage> pages = pagesOf(encode(grid, isKnown, sections.terrain, of_known, coder));
  for (KnownPage& page : pages)
    if (const PageKnowledge* given = find(sections.known, page.first)) page.knowledge.finest = given->finest;
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
