// Names of vertices and nodes. A node is one refinement vertex: the midpoint of an edge of a coarser mesh plus a
// displacement. On a grid of root squares a vertex *is* its lattice position, so everything else (level, endpoints,
// parents, children) follows by integer arithmetic in grid.h.
//
//   bits 0..31  x, in samples eastward (or along the raster's row)
//   bits 32..63 y, in samples northward
//
// Consequences: ids compare by y then x; the midpoint of two vertices is the id of their mean; no table maps ids to
// positions. Value type; any thread; portable to WebAssembly.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace foreland::proto {

struct NodeId {
  uint64_t bits = 0;

  static constexpr NodeId at(uint32_t x, uint32_t y) { return {static_cast<uint64_t>(y) << 32 | x}; }
  constexpr uint32_t x() const { return static_cast<uint32_t>(bits); }
  constexpr uint32_t y() const { return static_cast<uint32_t>(bits >> 32); }
  auto operator<=>(const NodeId&) const = default;
};

// A node's place in the canonical order: coarse levels first, neighbours close together. A slot is a name: that a node
// has one does not say that anything is stored of it.
using Slot = uint64_t;
inline constexpr Slot kNoSlot = ~Slot{0};
// Every slot is less than 2 to this power, so that the key of a page takes six bytes.
inline constexpr int kSlotBits = 56;
// A page is this many consecutive slots, which are a tile of the level: neighbours share a page. A level begins with a
// page. Pages have keys: the key of a slot's page is the slot divided by this.
inline constexpr Slot kPageSlots = 256;

// Up to `Capacity` ids without allocation.
template <int Capacity>
struct NodeList {
  NodeId ids[Capacity];
  int count = 0;
  constexpr void push(NodeId id) { ids[count++] = id; }
  constexpr const NodeId* begin() const { return ids; }
  constexpr const NodeId* end() const { return ids + count; }
};

}  // namespace foreland::proto

template <>
struct std::hash<foreland::proto::NodeId> {
  size_t operator()(foreland::proto::NodeId id) const noexcept {
    uint64_t z = id.bits * 0x9e3779b97f4a7c15ull;
    return static_cast<size_t>(z ^ (z >> 32));
  }
};
