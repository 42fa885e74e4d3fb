#include "server/section/node_flags.h"

namespace foreland::server {

void NodeFlags::set(proto::Slot slot, uint32_t plane, bool value) {
  const uint32_t key = slot >> 8;
  uint32_t cell = probe(key);
  if (cells_[cell].page == kEmpty) {
    if (!value) return;
    if (2 * (pages_.size() + 1) > cells_.size()) {
      grow();
      cell = probe(key);
    }
    cells_[cell] = {key, static_cast<uint32_t>(pages_.size())};
    pages_.push_back({});
    pages_.back().key = key;
  }
  Page& page = pages_[cells_[cell].page];
  uint64_t& word = page.words[plane][slot >> 6 & 3];
  const uint64_t bit = uint64_t{1} << (slot & 63);
  if (((word & bit) != 0) == value) return;
  word ^= bit;
  page.bits_set += value ? 1 : -1;
  if (page.bits_set == 0) erase(cell);
}

void NodeFlags::grow() {
  cells_.assign(cells_.size() * 2, {});
  --shift_;
  for (uint32_t i = 0; i < pages_.size(); ++i) cells_[probe(pages_[i].key)] = {pages_[i].key, i};
}

// The last page takes the freed place; cells after the freed one move up where their chains passed over it.
void NodeFlags::erase(uint32_t cell) {
  const uint32_t freed = cells_[cell].page, last = static_cast<uint32_t>(pages_.size() - 1);
  if (freed != last) {
    cells_[probe(pages_[last].key)].page = freed;
    pages_[freed] = pages_[last];
  }
  pages_.pop_back();
  uint32_t hole = cell;
  for (uint32_t at = (cell + 1) & mask(); cells_[at].page != kEmpty; at = (at + 1) & mask()) {
    const uint32_t from = home(cells_[at].key);
    if (((at - from) & mask()) >= ((at - hole) & mask())) {
      cells_[hole] = cells_[at];
      hole = at;
    }
  }
  cells_[hole] = {};
}

}  // namespace foreland::server
