#include "proto/delta_codec.h"

namespace foreland::proto::codec_detail {

void putSlots(const std::vector<Slot>& slots, ByteWriter& writer) {
  writer.putVarint(slots.size());
  Slot next = 0;
  for (Slot slot : slots) {
    writer.putVarint(slot - next);
    next = slot + 1;
  }
}

Status getSlots(const GridTopology& grid, ByteReader& reader, std::vector<Slot>& slots) {
  const uint64_t count = reader.getVarint();
  // Each slot takes at least a byte, so a count beyond what is left is a lie, told before any allocation.
  if (!reader.ok() || count > reader.remaining())
    return Error{ErrorCode::kMalformed, "cut delta: more slots announced than bytes sent"};
  slots.clear();
  slots.reserve(count);
  uint64_t next = 0;
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t gap = reader.getVarint();
    if (!reader.ok() || gap >= grid.slotCount() || next + gap >= grid.slotCount())
      return Error{ErrorCode::kMalformed, "cut delta: a slot beyond the scene"};
    const Slot slot = static_cast<Slot>(next + gap);
    if (grid.isBase(grid.node(slot))) return Error{ErrorCode::kMalformed, "cut delta: a slot that is no node"};
    slots.push_back(slot);
    next = uint64_t{slot} + 1;
  }
  return {};
}

}  // namespace foreland::proto::codec_detail
