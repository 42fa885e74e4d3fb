#include "server/section/node_flags.h"

namespace foreland::server {

void NodeFlags::set(Flag flag, proto::Slot slot, bool value) {
  const uint32_t key = slot >> 8;
  uint32_t cell = probe(key);
  if (cells_[cell].page == kEmpty) {
    if (!value) return;
    if (2 * (pages_.size() + 1) > cells_.size()) {
      grow();
      cell = probe(key);
    }
    cells_[cell] = {key, static_cast<uint32_t>(pages_.size())};
    if (pages_.size() == pages_.capacity()) {  // grows by an eighth, for a session's memory is counted
      pages_.reserve(pages_.size() + pages_.size() / 8 + 64);
      infos_.reserve(pages_.capacity());
    }
    pages_.push_back({});
    infos_.push_back({key, 0});
  }
  const uint32_t page = cells_[cell].page;
  uint64_t& word = pages_[page][slot >> 6 & 3][flag];
  const uint64_t bit = uint64_t{1} << (slot & 63);
  if (((word & bit) != 0) == value) return;
  word ^= bit;
  infos_[page].bits_set += value ? 1 : -1;
  if (infos_[page].bits_set == 0) erase(cell);
}

void NodeFlags::grow() {
  cells_.assign(cells_.size() * 2, {});
  --shift_;
  for (uint32_t i = 0; i < infos_.size(); ++i) cells_[probe(infos_[i].key)] = {infos_[i].key, i};
}

// The last page takes the freed place; cells after the freed one move up where their chains passed over it.
void NodeFlags::erase(uint32_t cell) {
  const uint32_t freed = cells_[cell].page, last = static_cast<uint32_t>(pages_.size() - 1);
  if (freed != last) {
    cells_[probe(infos_[last].key)].page = freed;
    pages_[freed] = pages_[last];
    infos_[freed] = infos_[last];
  }
  pages_.pop_back();
  infos_.pop_back();
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
