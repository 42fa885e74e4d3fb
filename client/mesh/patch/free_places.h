// Places in a vector that are taken again once they are free.
#pragma once

#include <cstdint>
#include <vector>

namespace foreland::client {

// The place that became free last, with what it last held; a new one at the end if none is free.
template <class T>
uint32_t takePlace(std::vector<T>& all, std::vector<uint32_t>& free) {
  if (free.empty()) {
    all.emplace_back();
    return static_cast<uint32_t>(all.size() - 1);
  }
  const uint32_t place = free.back();
  free.pop_back();
  return place;
}

}  // namespace foreland::client
