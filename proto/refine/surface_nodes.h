// The records of a surface as an adapter takes them, without a wire. A view; any thread.
#pragma once

#include <algorithm>
#include <span>

#include "proto/refine/adapter.h"
#include "proto/refine/surface_batch.h"

namespace foreland::proto {

using SurfaceAdapter = Adapter<SurfaceBatch>;

class InMemorySurfaceNodes final : public NodeSource<SurfaceBatch> {
 public:
  explicit InMemorySurfaceNodes(std::span<const SurfaceRecord> records) : records_(records.data()) {}
  QuantisedRadius radius(Slot) override { return {}; }
  void load(SurfaceBatch& batch) override {
    for (size_t i = 0; i < batch.count; ++i) batch.record[i] = records_[batch.slot[i]];
  }
  // There are none.
  bool decide(int, std::span<const Predicate> predicates, std::span<uint8_t>) override { return predicates.empty(); }

 private:
  const SurfaceRecord* records_;
};

}  // namespace foreland::proto
