#include "terrain/store/coded/group_reader.h"

#include <algorithm>
#include <utility>

#include "terrain/store/coded/group_codec.h"

namespace foreland::terrain {

GroupReader::GroupReader(uint64_t places, Read read)
    : places_(places), read_(std::move(read)), held_at_((places + kGroupRecords - 1) / kGroupRecords, kNone) {}

const proto::NodeRecord& GroupReader::at(uint64_t place) {
  return hold(place / kGroupRecords).records[place % kGroupRecords];
}

std::span<const proto::NodeRecord> GroupReader::group(uint64_t index) { return hold(index).records; }

GroupReader::Held& GroupReader::hold(uint64_t index) {
  uint32_t& at = held_at_[index];
  if (at == kNone) {
    Held& held = least();
    at = static_cast<uint32_t>(&held - held_.data());
    held.group = index;
    held.records.assign(std::min(kGroupRecords, places_ - index * kGroupRecords), {});
    if (Status s = read_(index * kGroupRecords, held.records); !s.ok()) {
      std::ranges::fill(held.records, proto::NodeRecord{});
      if (status_.ok()) status_ = std::move(s);
    }
  }
  held_[at].used = ++clock_;
  return held_[at];
}

// An entry that is free, or that was asked for the longest ago.
GroupReader::Held& GroupReader::least() {
  if (held_.size() < kHeld) {
    held_.reserve(kHeld);  // records stay where they are
    return held_.emplace_back();
  }
  Held& held = *std::ranges::min_element(held_, {}, &Held::used);
  held_at_[held.group] = kNone;
  return held;
}

}  // namespace foreland::terrain
