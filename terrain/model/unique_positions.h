// Vertices for files that repeat a position at each face or seam: equal positions become one vertex. One owner.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <unordered_map>

#include "base/result.h"
#include "terrain/model/checked_model.h"

namespace foreland::terrain {

class UniquePositions {
 public:
  explicit UniquePositions(CheckedModel& model) : model_(model) {}

  // The vertex at a position, which is added if it is new. Errors are those of CheckedModel::addPosition.
  Result<uint32_t> vertexAt(const glm::dvec3& position) {
    const Key key{keyOf(position.x), keyOf(position.y), keyOf(position.z)};
    const auto [found, is_new] = vertices_.try_emplace(key, static_cast<uint32_t>(model_.get().positions.size()));
    if (is_new)
      if (Status status = model_.addPosition(position); !status.ok()) return status.error();
    return found->second;
  }

 private:
  using Key = std::array<uint64_t, 3>;
  struct Hash {
    size_t operator()(const Key& key) const {
      uint64_t hash = 0;
      for (uint64_t part : key) hash = (hash ^ part ^ part >> 29) * 0x9e3779b97f4a7c15u, hash ^= hash >> 32;
      return hash;
    }
  };
  static uint64_t keyOf(double coordinate) { return std::bit_cast<uint64_t>(coordinate + 0.0); }  // -0 is 0

  CheckedModel& model_;
  std::unordered_map<Key, uint32_t, Hash> vertices_;
};

}  // namespace foreland::terrain
