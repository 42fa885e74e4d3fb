// The records of a terrain that lie in a file, for who codes its pages (group_codec.h): groups are read as they are
// asked for, and the last few that were stay in memory. One owner.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/result.h"
#include "proto/section/node_tables.h"

namespace foreland::terrain {

class GroupReader {
 public:
  // Fills `out` with the records from a place on.
  using Read = std::function<Status(uint64_t first, std::span<proto::NodeRecord> out)>;

  // `places` is how many records there are. Memory: 4 MiB, and four bytes a group.
  GroupReader(uint64_t places, Read read);

  // Valid until kHeld - 1 other groups were asked for. Once a group cannot be read, its records are zeros.
  const proto::NodeRecord& at(uint64_t place);
  std::span<const proto::NodeRecord> group(uint64_t index);
  // The first failure.
  const Status& status() const { return status_; }

  // Nodes of a group have parents on all coarser levels, near each other: a few groups of each.
  static constexpr uint32_t kHeld = 128;

 private:
  static constexpr uint32_t kNone = ~0u;
  struct Held {
    uint64_t group = 0, used = 0;
    std::vector<proto::NodeRecord> records{};
  };
  Held& hold(uint64_t index);
  Held& least();

  uint64_t places_;
  Read read_;
  std::vector<uint32_t> held_at_;  // by group
  std::vector<Held> held_;
  uint64_t clock_ = 0;
  Status status_;
};

}  // namespace foreland::terrain
