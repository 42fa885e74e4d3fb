#include "terrain/dem/voids/push_rows.h"

#include <algorithm>

#include "terrain/dem/voids/void_regions.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kSweeps = 8;

struct BandRow {
  std::vector<float> values;
  RunsOfRow runs;
};

class Pusher {
 public:
  Pusher(const PushInput& input, const TakeRow& take)
      : in_(input), take_(take), coarse_(input.coarse.width, input.readCoarse) {
    for (BandRow& row : band_) row.values.resize(in_.fine.width);
  }

  Status push() {
    const uint32_t height = in_.fine.height;
    for (uint32_t y = 0; y < height + kSweeps; ++y) {
      if (y < height)
        if (Status s = enter(y); !s.ok()) return s;
      for (uint32_t sweep = 1; sweep <= std::min(y, kSweeps); ++sweep)
        if (y - sweep < height) relax(y - sweep);
      if (y < kSweeps) continue;
      if (const BandRow& done = at(y - kSweeps); !done.runs.empty())
        if (Status s = take_(y - kSweeps, done.values, done.runs); !s.ok()) return s;
    }
    return {};
  }

 private:
  // The row that comes in, those that are swept, and the one south of these.
  BandRow& at(uint32_t y) { return band_[y % band_.size()]; }

  bool isNeeded(uint32_t y) const {
    return in_.has_void[y] || (y > 0 && in_.has_void[y - 1]) || (y + 1 < in_.fine.height && in_.has_void[y + 1]);
  }

  Status enter(uint32_t y) {
    BandRow& row = at(y);
    row.runs.clear();
    if (!isNeeded(y)) return {};
    if (Status s = in_.readFine(y, row.values); !s.ok()) return s;
    if (!in_.has_void[y]) return {};
    forEachVoidRun(row.values, [&](uint32_t begin, uint32_t end) { row.runs.emplace_back(begin, end); });
    return interpolate(y, row);
  }

  // The coarse level at the centres of fine samples, bilinear.
  Status interpolate(uint32_t y, BandRow& row) {
    const uint32_t y1 = y / 2;
    const uint32_t y2 = y & 1 ? std::min(y1 + 1, in_.coarse.height - 1) : (y1 == 0 ? 0 : y1 - 1);
    // From south to north.
    if (const auto first = coarse_.at(std::min(y1, y2)); !first) return first.error();
    const auto near = coarse_.at(y1), far = coarse_.at(y2);
    if (!near || !far) return near ? far.error() : near.error();
    for (const auto& [begin, end] : row.runs)
      for (uint32_t x = begin; x < end; ++x) {
        const uint32_t x1 = x / 2;
        const uint32_t x2 = x & 1 ? std::min(x1 + 1, in_.coarse.width - 1) : (x1 == 0 ? 0 : x1 - 1);
        row.values[x] =
            0.75f * (0.75f * (*near)[x1] + 0.25f * (*near)[x2]) + 0.25f * (0.75f * (*far)[x1] + 0.25f * (*far)[x2]);
      }
    return {};
  }

  // Each void of a row becomes the mean of its neighbours.
  void relax(uint32_t y) {
    BandRow& row = at(y);
    if (row.runs.empty()) return;
    float* here = row.values.data();
    const float* south = y > 0 ? at(y - 1).values.data() : here;
    const float* north = y + 1 < in_.fine.height ? at(y + 1).values.data() : here;
    const uint32_t last = in_.fine.width - 1;
    for (const auto& [begin, end] : row.runs)
      for (uint32_t x = begin; x < end; ++x) {
        const float w = here[x > 0 ? x - 1 : x], e = here[x < last ? x + 1 : x];
        here[x] = 0.25f * ((w + e) + (south[x] + north[x]));
      }
  }

  const PushInput& in_;
  const TakeRow& take_;
  RowCache coarse_;
  std::array<BandRow, kSweeps + 2> band_;
};

}  // namespace

Status pushRows(const PushInput& input, const TakeRow& take) { return Pusher(input, take).push(); }

}  // namespace foreland::terrain
