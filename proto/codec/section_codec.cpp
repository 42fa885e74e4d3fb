#include "proto/codec/section_codec.h"

#include <algorithm>
#include <array>
#include <string>

#include "base/check.h"
#include "proto/codec/range_coder.h"

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
    const auto isIn = [&](NodeId n) { return std::binary_search(included.begin(), included.end(), topology.slot(n)); };
    for (Slot slot : included)
      for (NodeId child : topology.children(topology.node(slot))) {
        const auto parents = topology.parents(child);
        if (std::all_of(parents.begin(), parents.end(), isIn)) candidates.push_back(topology.slot(child));
      }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  }
  return true;
}

// Of the terrain, and of all objects.
constexpr int kMaxLevels = std::max(GridTopology::kMaxLevels, MeshTopology::kMaxLevels);
using Model = std::array<AdaptiveBit, 8 * (kMaxLevels + 1)>;

// Writes a section.
template <class Topology>
void encode(const Topology& topology, const Section& section, Model& model, RangeEncoder& coder) {
  Section visited;
  descend(topology, visited, [&](Slot slot, size_t context) {
    const bool is_in = contains(section, slot);
    return coder.code(model[context], is_in) ? 1 : 0;
  });
}

// Reads one; takes its nodes off `room`. False if there is not enough, or the bytes end.
template <class Topology>
bool decode(const Topology& topology, Section& section, size_t& room, Model& model, RangeDecoder& coder) {
  return descend(topology, section, [&](Slot, size_t context) {
    if (coder.overrun()) return -1;
    const bool is_in = coder.code(model[context]);
    if (is_in && room-- == 0) return -1;
    return is_in ? 1 : 0;
  });
}

}  // namespace

uint32_t fingerprint(const HeldSections& sections) {
  uint32_t sum = fingerprint(sections.terrain.slots);
  for (size_t i = 0; i < sections.objects.size(); ++i) sum += fingerprintOf(i, {sections.objects[i].slots, {}});
  return sum;
}

void encodeSections(const GridTopology& grid, const ObjectSet& objects, const HeldSections& sections, Bytes& out) {
  CHECK_EQ(sections.objects.size(), objects.size());
  RangeEncoder coder(out);
  Model of_terrain, of_objects;
  encode(grid, sections.terrain, of_terrain, coder);
  for (size_t i = 0; i < objects.size(); ++i)
    encode(objects.domain(i).topology(), sections.objects[i], of_objects, coder);
  coder.finish();
}

Result<HeldSections> decodeSections(const GridTopology& grid, const ObjectSet& objects, ByteSpan bytes,
                                    size_t max_nodes) {
  const auto malformed = [](const char* what) { return Error{ErrorCode::kMalformed, std::string("section: ") + what}; };
  RangeDecoder coder(bytes);
  Model of_terrain, of_objects;
  HeldSections sections;
  bool done = decode(grid, sections.terrain, max_nodes, of_terrain, coder);
  for (size_t i = 0; done && i < objects.size(); ++i)
    done = decode(objects.domain(i).topology(), sections.objects.emplace_back(), max_nodes, of_objects, coder);
  if (!done) return malformed("more nodes than bytes, or than are served");
  if (!coder.atEnd()) return malformed("cut short, or bytes left over");
  return sections;
}

}  // namespace foreland::proto
