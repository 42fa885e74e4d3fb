// The records of a surface as an adapter takes them, without a wire. A view; any thread.
#pragma once

#include <algorithm>
#include <span>

#include "proto/refine/adapter.h"
#include "proto/refine/surface_batch.h"

namespace foreland::proto {

using SurfaceAdapter = Adapter<SurfaceBatch>;

class PlainSurfaceNodes final : public NodeSource<SurfaceBatch> {
 public:
  explicit PlainSurfaceNodes(std::span<const SurfaceRecord> records) : records_(records.data()) {}
  RadiusClass radius(Slot) override { return {}; }
  void load(SurfaceBatch& batch) override {
    for (size_t i = 0; i < batch.count; ++i) batch.record[i] = records_[batch.slot[i]];
  }
  // There are none.
  bool answer(int, std::span<const Question> questions, std::span<uint8_t>) override { return questions.empty(); }

 private:
  const SurfaceRecord* records_;
};

}  // namespace foreland::proto
