#include "proto/section_codec.h"

#include <algorithm>

#include "proto/range_coder.h"

namespace foreland::proto {

namespace {

// Visits the candidates of each level; `answer(slot, context)` says which are in. Returns false when it gives up.
template <class Topology, class Answer>
bool descend(const Topology& topology, Section& section, const Answer& answer) {
  std::vector<Slot> candidates, included;
  for (Slot slot = topology.levelOffset(1); slot < topology.levelOffset(2); ++slot)
    if (!topology.isBase(topology.node(slot))) candidates.push_back(slot);
  for (int level = 1; level <= topology.maxLevel() && !candidates.empty(); ++level) {
    included.clear();
    size_t before = 0;  // the last three answers
    for (Slot slot : candidates) {
      const size_t context = static_cast<size_t>(level) * 8 + before;
      const int got = answer(slot, context);
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

using Model = std::vector<AdaptiveBit>;
Model newModel(const GridTopology& topology) { return Model(8 * (static_cast<size_t>(topology.maxLevel()) + 1)); }

}  // namespace

void encodeSection(const GridTopology& topology, const Section& section, Bytes& out) {
  RangeEncoder coder(out);
  Model model = newModel(topology);
  Section visited;
  descend(topology, visited, [&](Slot slot, size_t context) {
    const bool is_in = std::binary_search(section.slots.begin(), section.slots.end(), slot);
    return coder.code(model[context], is_in) ? 1 : 0;
  });
  coder.finish();
}

Result<Section> decodeSection(const GridTopology& topology, ByteSpan bytes, size_t max_nodes) {
  const auto malformed = [](const char* what) { return Error{ErrorCode::kMalformed, std::string("section: ") + what}; };
  RangeDecoder coder(bytes);
  Model model = newModel(topology);
  Section section;
  size_t count = 0;
  const bool done = descend(topology, section, [&](Slot, size_t context) {
    if (coder.overrun() || count > max_nodes) return -1;
    const bool is_in = coder.code(model[context]);
    count += is_in ? 1 : 0;
    return is_in ? 1 : 0;
  });
  if (!done || count > max_nodes) return malformed("more nodes than bytes, or than are served");
  if (!coder.atEnd()) return malformed("cut short, or bytes left over");
  return section;
}

}  // namespace foreland::proto
