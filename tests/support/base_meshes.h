// Base meshes chosen by property: closed and open, odd valences, several borders, faces that share all their edges;
// also with faces and corners shuffled, so that every side meets every other.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "proto/topology/base_mesh.h"

namespace foreland::test {

struct NamedBase {
  std::string name;
  uint32_t vertices = 0;
  std::vector<proto::BaseFace> faces;
  bool closed = false;
};

// `columns` x `rows` squares, each halved, glued into a torus.
inline NamedBase torusBase(uint32_t columns, uint32_t rows) {
  NamedBase base{"Torus", columns * rows, {}, true};
  for (uint32_t y = 0; y < rows; ++y)
    for (uint32_t x = 0; x < columns; ++x) {
      const auto at = [&](uint32_t dx, uint32_t dy) { return (y + dy) % rows * columns + (x + dx) % columns; };
      base.faces.push_back({at(0, 0), at(1, 0), at(1, 1)});
      base.faces.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
  return base;
}

inline NamedBase fanBase(uint32_t valence) {
  NamedBase base{"FanOf" + std::to_string(valence), valence + 1, {}, false};
  for (uint32_t i = 0; i < valence; ++i) base.faces.push_back({0, 1 + i, 1 + (i + 1) % valence});
  return base;
}

inline NamedBase shuffled(NamedBase base, uint64_t seed) {
  Rng rng(seed);
  base.name = "Shuffled" + base.name;
  for (size_t i = base.faces.size(); i > 1; --i) std::swap(base.faces[i - 1], base.faces[rng.below(i)]);
  for (proto::BaseFace& f : base.faces)
    for (uint64_t turns = rng.below(3); turns > 0; --turns) f = {f[1], f[2], f[0]};
  return base;
}

inline std::vector<NamedBase> baseMeshes() {
  const NamedBase octahedron{
      "Octahedron", 6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}}, true};
  const NamedBase tube{"Tube", 6, {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}}, false};
  return {{"Triangle", 3, {{0, 1, 2}}, false},
          {"Dihedron", 3, {{0, 1, 2}, {1, 0, 2}}, true},
          {"Tetrahedron", 4, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}, true},
          octahedron,
          shuffled(octahedron, 1),
          fanBase(3),
          shuffled(fanBase(7), 2),
          tube,
          shuffled(tube, 3),
          torusBase(3, 3),
          shuffled(torusBase(3, 3), 4)};
}

}  // namespace foreland::test
