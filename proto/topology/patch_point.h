// How a node of a surface is named: by the patch whose lattice it lies on and its position there. A patch is a base
// face (quadrisection.h) or the square about a base edge (bisection.h); lattices have 2^k intervals a side.
//
//   bits 0..15   x
//   bits 16..31  y
//   bits 32..63  1 + patch; 0 marks base vertices, whose number then stands in the bits below
//
// A node on the side between two patches is named by the patch that owns it. Value types; any thread; portable.
#pragma once

#include <bit>
#include <cstdint>

#include "proto/topology/node.h"

namespace foreland::proto {

struct PatchPoint {
  uint32_t patch = 0;
  int32_t x = 0, y = 0;

  // log2 of the largest power of two that divides both coordinates; not both are 0.
  uint32_t scaleLog2() const { return static_cast<uint32_t>(std::countr_zero(static_cast<uint32_t>(x | y))); }
  PatchPoint moved(int32_t dx, int32_t dy) const { return {patch, x + dx, y + dy}; }
  bool operator==(const PatchPoint&) const = default;
};

// A node's positions on the one or two patches that hold it.
struct PatchPoints {
  PatchPoint at[2];
  int count = 0;
  void push(const PatchPoint& p) { at[count++] = p; }
  const PatchPoint* begin() const { return at; }
  const PatchPoint* end() const { return at + count; }
};

// A vertex in the parameter domain: its barycentric coordinates in a base face are the weights divided by their sum.
// Integers, so that the same point compares equal.
struct FacePoint {
  uint32_t face = 0;
  uint32_t weights[3] = {0, 0, 0};
};

constexpr NodeId baseVertexId(uint32_t vertex) { return {vertex}; }
constexpr bool isBaseVertexId(NodeId n) { return n.bits >> 32 == 0; }
constexpr uint32_t baseVertexOf(NodeId n) { return static_cast<uint32_t>(n.bits); }

constexpr NodeId patchNodeId(const PatchPoint& p) {
  return {(uint64_t{p.patch} + 1) << 32 | static_cast<uint64_t>(p.y) << 16 | static_cast<uint64_t>(p.x)};
}
constexpr PatchPoint patchPointOf(NodeId n) {
  return {static_cast<uint32_t>(n.bits >> 32) - 1, static_cast<int32_t>(n.bits & 0xffff),
          static_cast<int32_t>(n.bits >> 16 & 0xffff)};
}

}  // namespace foreland::proto
