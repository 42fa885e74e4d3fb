// The last few rows that were read of a grid, for walks that look at neighbouring rows and go north. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "base/result.h"

namespace foreland::terrain {

// Fills `out` with row y.
using ReadRow = std::function<Status(uint32_t y, std::span<float> out)>;

class RowCache {
 public:
  RowCache(uint32_t width, ReadRow read) : read_(std::move(read)) {
    for (Row& row : rows_) row.values.resize(width);
  }
  // Stays as it is until a row four rows further is asked for.
  Result<std::span<const float>> at(uint32_t y) {
    Row& row = rows_[y % rows_.size()];
    if (row.y != int64_t{y}) {
      row.y = -1;
      if (Status s = read_(y, row.values); !s.ok()) return s.error();
      row.y = y;
    }
    return std::span<const float>(row.values);
  }

 private:
  struct Row {
    int64_t y = -1;
    std::vector<float> values;
  };
  ReadRow read_;
  std::array<Row, 4> rows_;
};

}  // namespace foreland::terrain
