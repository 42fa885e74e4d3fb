// One number for a section and its heights, to compare clients with that were built differently. Portable.
#pragma once

#include "client/replica.h"

namespace foreland::lab {

inline uint32_t digestOf(const client::Replica& replica) {
  uint32_t digest = 0;
  for (proto::Slot slot : replica.section().slots) {
    const int32_t height = replica.nodes().records().at(slot).height();
    digest = (digest ^ static_cast<uint32_t>(slot)) * 0x01000193u + static_cast<uint32_t>(height);
  }
  return digest;
}

}  // namespace foreland::lab
