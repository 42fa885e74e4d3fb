#include "terrain/bounds/fine_errors.h"

#include "terrain/bounds/four.h"
#include "terrain/bounds/support.h"

namespace foreland::terrain {

FineErrors::FineErrors(const proto::GridTopology& grid, const Heights& heights, const NodeLevel& level)
    : grid_(grid),
      heights_(heights),
      level_(level),
      period_((level.sides ? 2 : 4) * level.s),
      stride_(heights.width / period_ + 2 + 4) {
}  // the last partial period, one more for rounding up, and what a vector reads past the end

const int32_t* FineErrors::sorted(uint32_t y) {
  SortedRow& row = kept_[y % kept_.size()];
  if (row.used && row.y == y) return row.quanta.data();
  row.used = true;
  row.y = y;
  row.quanta.resize(period_ * stride_);
  const int32_t* from = heights_.row(y);
  for (uint32_t remainder = 0; remainder < period_; ++remainder) {
    int32_t* to = row.quanta.data() + remainder * stride_;
    for (uint32_t x = remainder; x < heights_.width; x += period_) *to++ = from[x];
  }
  return row.quanta.data();
}

FineErrors::Range FineErrors::compute(const NodeRow& row, std::span<double> errors) {
  const uint32_t s = level_.s;
  if (row.y + s >= heights_.height && row.y + s <= grid_.maxY()) return {};  // the support reaches beyond the data
  if (row.y >= heights_.height || heights_.width < row.first_x + 2 * s + 1) return {};
  const uint32_t first = row.first_x == 0 ? 1 : 0;
  const uint32_t last = std::min(row.count, (heights_.width - 1 - s - row.first_x) / row.step_x + 1);
  if (last <= first) return {};
  const uint32_t families = level_.sides ? 1 : 2;  // along a row, diagonals rise and fall alternately
  for (uint32_t f = 0; f < families; ++f) family(row, first + f, families, last, errors);
  return {first, last};
}

// Every `every`-th node from `first`: these have supports of the same shape, one period apart.
void FineErrors::family(const NodeRow& row, uint32_t first, uint32_t every, uint32_t last, std::span<double> errors) {
  if (first >= last) return;
  const uint32_t count = (last - first + every - 1) / every;
  const proto::NodeId n = row.node(first);
  const auto ends = grid_.endpoints(n);
  family_errors_.assign(count + 4, 0);
  const auto at = [&](proto::NodeId v) { return sorted(v.y()) + sortedIndex(v.x()); };
  for (proto::NodeId apex : grid_.apexes(n)) {
    const SupportTriangle triangle(n, ends, apex);
    const int32_t *a = at(triangle.a), *b = at(triangle.b), *p = at(apex);
    struct Line {
      int32_t dy, first, last;
      const int32_t* quanta;
    };
    std::array<Line, 2 * kLargestReach + 1> lines;
    size_t line_count = 0;
    triangle.forEachRow([&](int32_t dy, int32_t from, int32_t to) {
      lines[line_count++] = {dy, from, to, sorted(n.y() + static_cast<uint32_t>(dy))};
    });
    std::array<size_t, 2 * kLargestReach + 1> offsets;
    const auto reach = static_cast<int32_t>(level_.s);
    for (int32_t dx = -reach; dx <= reach; ++dx)
      offsets[static_cast<uint32_t>(dx + reach)] = sortedIndex(n.x() + static_cast<uint32_t>(dx));
    for (uint32_t i = 0; i < count; i += 4) {
      const Plane<Four> plane = triangle.plane(loadFour(a + i), loadFour(b + i), loadFour(p + i));
      Four worst = loadFour(&family_errors_[i]);
      for (size_t k = 0; k < line_count; ++k) {
        const Line& line = lines[k];
        Four value = plane.at(line.first, line.dy);
        for (int32_t dx = line.first; dx <= line.last; ++dx, value += plane.per_x)
          worst =
              larger(worst, magnitude(loadFour(line.quanta + offsets[static_cast<uint32_t>(dx + reach)] + i) - value));
      }
      storeFour(&family_errors_[i], worst);
    }
  }
  for (uint32_t i = 0; i < count; ++i) errors[first + i * every] = family_errors_[i];
}

}  // namespace foreland::terrain
