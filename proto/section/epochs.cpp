#include "proto/section/epochs.h"

#include <cmath>
#include <string>
#include <tuple>

#include "base/sort.h"

namespace foreland::proto {

LatticeWindow LatticeWindow::hull(const LatticeWindow& a, const LatticeWindow& b) {
  if (a.isEmpty()) return b;
  if (b.isEmpty()) return a;
  const uint32_t x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

LatticeWindow LatticeWindow::common(const LatticeWindow& a, const LatticeWindow& b) {
  const uint32_t x = std::max(a.x, b.x), y = std::max(a.y, b.y), end_x = std::min(a.x + a.width, b.x + b.width),
                 end_y = std::min(a.y + a.height, b.y + b.height);
  if (end_x <= x || end_y <= y) return {};
  return {x, y, end_x - x, end_y - y};
}

namespace {

bool isBefore(const BaseOffset& a, const BaseOffset& b) {
  return std::tie(a.epoch, a.vertex) < std::tie(b.epoch, b.vertex);
}

}  // namespace

void sortBaseOffsets(std::vector<BaseOffset>& offsets) { foreland::sort(offsets.begin(), offsets.end(), isBefore); }

int32_t baseOffsetAt(std::span<const BaseOffset> sorted, uint32_t epoch, uint32_t vertex) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), BaseOffset{epoch, vertex, 0}, isBefore);
  return at != sorted.end() && at->epoch == epoch && at->vertex == vertex ? at->quanta : 0;
}

uint32_t baseVertexNumber(const GridTopology& grid, NodeId base) {
  const uint32_t k = grid.shape().root_log2, x = base.x() >> k, y = base.y() >> k, row = grid.shape().roots_x + 1;
  if (grid.scaleLog2(base) >= k) return y * row + x;
  return row * (grid.shape().roots_y + 1) + y * grid.shape().roots_x + x;
}

NodeId baseVertex(const GridTopology& grid, uint32_t number) {
  const uint32_t k = grid.shape().root_log2, row = grid.shape().roots_x + 1, corners = row * (grid.shape().roots_y + 1);
  if (number < corners) return NodeId::at(number % row << k, number / row << k);
  const uint32_t roots_x = grid.shape().roots_x, half = 1u << k >> 1;
  number -= corners;
  return NodeId::at((number % roots_x << k) + half, (number / roots_x << k) + half);
}

std::optional<EpochBlend> epochBlendOf(uint32_t number) {
  if (number >= kEpochBlendNames.size()) return std::nullopt;
  return static_cast<EpochBlend>(number);
}

std::array<std::array<double, 4>, 2> EpochCurve::accelerations() const {
  std::array<std::array<double, 4>, 2> out{};
  for (size_t end = 0; end < 2; ++end)
    for (uint32_t i = 0; i < count; ++i)
      out[end][i] = 6 * (controls[end][i] - 2 * controls[end + 1][i] + controls[end + 2][i]);
  return out;
}

Result<Epochs> Epochs::create(const GridShape& shape, std::vector<Epoch> epochs, EpochBlend blend) {
  const auto malformed = [](size_t i, const char* what) {
    return Error{ErrorCode::kMalformed, "epoch " + std::to_string(i + 1) + " " + what};
  };
  if (epochs.size() > kMax) return Error{ErrorCode::kLimit, "a scene has at most 1024 epochs"};
  for (size_t i = 0; i < epochs.size(); ++i) {
    const Epoch& epoch = epochs[i];
    const LatticeWindow& w = epoch.moved;
    if (epoch.time.us < -kMaxTime_us || epoch.time.us > kMaxTime_us) return malformed(i, "has an absurd date");
    if (i > 0 && epoch.time <= epochs[i - 1].time) return malformed(i, "is not later than the one before it");
    if (uint64_t{w.x} + w.width > shape.samples_x || uint64_t{w.y} + w.height > shape.samples_y)
      return malformed(i, "reaches beyond the data");
    if (i == 0 && !w.isEmpty()) return malformed(i, "differs from itself");
  }
  Epochs out;
  out.epochs_ = std::move(epochs);
  out.blend_ = blend;
  out.last_x_ = shape.samples_x - 1;
  out.last_y_ = shape.samples_y - 1;
  return out;
}

Time Epochs::clamp(double us) const {
  if (!(us > static_cast<double>(first().us))) return first();
  if (us >= static_cast<double>(last().us)) return last();
  return {static_cast<int64_t>(us)};
}

double Epochs::date(int64_t epoch) const {
  const auto i = static_cast<size_t>(std::clamp<int64_t>(epoch, 0, static_cast<int64_t>(epochs_.size()) - 1));
  return (epochs_[i].time - first()).toSeconds();
}

namespace {

using Weights = std::array<double, 4>;

Weights mix(double share, const Weights& a, const Weights& b) {
  Weights out;
  for (size_t i = 0; i < out.size(); ++i) out[i] = (1 - share) * a[i] + share * b[i];
  return out;
}

// Of one epoch alone, which is `at`-th of those blended.
Weights alone(uint32_t at) {
  Weights out{};
  out[at] = 1;
  return out;
}

}  // namespace

EpochCurve Epochs::curveAfter(uint32_t epoch) const {
  return blend_ == EpochBlend::kBSpline ? bSpline(epoch) : catmullRom(epoch);
}

// The epochs that a cubic blend needs after `epoch`: one more on either side, if there is one.
EpochCurve Epochs::neighbours(uint32_t epoch) const {
  EpochCurve curve;
  curve.first = epoch == 0 ? 0 : epoch - 1;
  curve.count = std::min(epoch + 3, static_cast<uint32_t>(epochs_.size())) - curve.first;
  return curve;
}

EpochCurve Epochs::catmullRom(uint32_t epoch) const {
  EpochCurve curve = neighbours(epoch);
  const uint32_t at = epoch - curve.first;
  const double third = (date(epoch + 1) - date(epoch)) / 3;
  // An epoch's height, and how far its speed goes from there in the time of `ahead`.
  const auto control = [&](uint32_t of, double ahead) {
    Weights weights = alone(of);
    const uint32_t before = of == 0 ? 0 : of - 1, after = std::min(of + 1, curve.count - 1);
    const double share = ahead / (date(curve.first + after) - date(curve.first + before));
    weights[after] += share;
    weights[before] -= share;
    return weights;
  };
  curve.controls = {alone(at), control(at, third), control(at + 1, -third), alone(at + 1)};
  return curve;
}

// By knot insertion: the inner control heights of a curve divide the line between two of the spline's, the outer ones
// that between the inner ones on either side.
EpochCurve Epochs::bSpline(uint32_t epoch) const {
  EpochCurve curve = neighbours(epoch);
  const int64_t last = static_cast<int64_t>(epochs_.size()) - 1;
  const auto height = [&](int64_t i) {
    return alone(static_cast<uint32_t>(std::clamp<int64_t>(i, 0, last)) - curve.first);
  };
  // Where `at` is on the line from spline height i to the next one.
  const auto between = [&](int64_t i, int64_t at) {
    const double begin = date(i - 1), end = date(i + 2);
    return mix((date(at) - begin) / (end - begin), height(i), height(i + 1));
  };
  const auto onDate = [&](int64_t i) {
    if (i == 0 || i == last) return height(i);
    const double before = date(i - 1), after = date(i + 1);
    return mix((date(i) - before) / (after - before), between(i - 1, i), between(i, i));
  };
  const int64_t i = epoch;
  curve.controls = {onDate(i), between(i, i), between(i, i + 1), onDate(i + 1)};
  return curve;
}

EpochWeights Epochs::weightsAt(Time scene_time) const {
  const auto after = std::upper_bound(epochs_.begin(), epochs_.end(), scene_time,
                                      [](Time t, const Epoch& epoch) { return t < epoch.time; });
  if (after == epochs_.begin()) return {};
  const auto at = static_cast<uint32_t>(after - epochs_.begin()) - 1;
  const bool is_on_date = after == epochs_.end() || epochs_[at].time == scene_time;
  const bool is_alone = at == 0 || after == epochs_.end() || blend_ != EpochBlend::kBSpline;
  if (is_on_date && is_alone) return {{at}, {1}, 1};
  const double share = is_on_date ? 0
                                  : static_cast<double>((scene_time - epochs_[at].time).us) /
                                        static_cast<double>((after->time - epochs_[at].time).us);
  if (blend_ == EpochBlend::kLinear) return {{at, at + 1}, {1 - share, share}, 2};
  const EpochCurve curve = curveAfter(at);
  const double rest = 1 - share;
  const Weights shares{rest * rest * rest, 3 * rest * rest * share, 3 * rest * share * share, share * share * share};
  EpochWeights out{{}, {}, is_on_date ? 3 : curve.count};
  for (uint32_t i = 0; i < out.count; ++i) {
    out.epoch[i] = curve.first + i;
    for (size_t k = 0; k < shares.size(); ++k) out.weight[i] += shares[k] * curve.controls[k][i];
  }
  return out;
}

std::array<double, 2> Epochs::range(std::span<const int32_t> values) const {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  std::array<double, 2> range{static_cast<double>(*least), static_cast<double>(*most)};
  if (blend_ != EpochBlend::kCatmullRom) return range;
  for (uint32_t epoch = 0; epoch + 1 < values.size(); ++epoch) {
    const EpochCurve curve = curveAfter(epoch);
    for (const Weights& weights : {curve.controls[1], curve.controls[2]}) {
      double value = 0;
      for (uint32_t i = 0; i < curve.count; ++i) value += weights[i] * values[curve.first + i];
      range = {std::min(range[0], value), std::max(range[1], value)};
    }
  }
  return range;
}

Time Epochs::towards(Time from, Time wanted) const {
  if (wanted > from) {
    for (const Epoch& epoch : epochs_)
      if (epoch.time > from && epoch.time < wanted) return epoch.time;
  } else {
    for (size_t i = epochs_.size(); i-- > 0;)
      if (epochs_[i].time < from && epochs_[i].time > wanted) return epochs_[i].time;
  }
  return wanted;
}

Time SceneClock::timeAt(const Epochs& epochs, Time t) const {
  return epochs.clamp(std::nearbyint(static_cast<double>(scene_time.us) +
                                     rate * static_cast<double>(std::max<int64_t>((t - at).us, 0))));
}

}  // namespace foreland::proto
