#include "server/occlusion/horizon_side.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace foreland::server {

namespace {

constexpr double kLineStep = 0.008;     // between two lines, of their distance
constexpr double kMostSlope = 2;        // that is kept: metres per metre
constexpr uint32_t kDistancesLog2 = 4;  // of distances between two powers of two
constexpr size_t kPrefetch = 6;         // lines

// Slopes are kept for distances that are evenly spread between powers of two: the first bits of a float are their
// numbers.
constexpr uint32_t kShift = 23 - kDistancesLog2;
constexpr uint32_t kFirst = std::bit_cast<uint32_t>(static_cast<float>(HorizonSide::kNearest)) >> kShift;
uint32_t distanceNumber(double ahead) {
  return (std::bit_cast<uint32_t>(static_cast<float>(ahead)) >> kShift) - kFirst;
}
float distanceOf(size_t number) { return std::bit_cast<float>((static_cast<uint32_t>(number) + kFirst) << kShift); }

}  // namespace

// The reference is the sweep's end that is farther ahead, and by the ball's radius farther.
void HorizonSide::look(const HorizonGrid& grid, const HorizonEyes& eyes, uint32_t number, double bin) {
  grid_ = &grid;
  is_x_ = number % 2 == 0;
  sign_ = number < 2 ? 1 : -1;
  along_ = is_x_ ? HorizonGrid::Along::kY : HorizonGrid::Along::kX;
  bin_ = bin;
  ball_ = eyes.ball;
  eye_m_ = eyes.highest_m;
  const glm::dvec2 begin = turned(eyes.begin), way = turned(eyes.way);
  reference_ = (way.x > 0 ? begin + way : begin) + glm::dvec2(ball_, 0);
  back_ = (way.x > 0 ? -way : way) - glm::dvec2(ball_, 0);
  depth_ = ball_ - back_.x;
  slopes_of_step_ = static_cast<float>(std::numeric_limits<int16_t>::max() / (kMostSlope * grid.metresOfStep()));
  segments_.resize(static_cast<size_t>(std::ceil(2 * kMostTangent / bin / kBins)));
  for (Segment& segment : segments_) segment.clear();
  findLines();
}

// Farther away, lines are left out, and those of coarser levels are taken, where a bin is wider than the vertices of a
// finer one are apart.
void HorizonSide::findLines() {
  lines_.clear();
  const auto& levels = grid_->levels();
  const auto along = static_cast<size_t>(along_);
  const double first = std::max(std::floor(reference_.x) + 1, sign_ > 0 ? 0.0 : 1.0 - levels[0].lines[along]);
  uint32_t level = 0;
  for (auto line = static_cast<int64_t>(first);;) {
    while (level < levels.size() &&
           (static_cast<double>(line) - reference_.x) * bin_ > HorizonLine::kMostStep * (1u << level))
      ++level;
    if (level == levels.size()) return;
    const int64_t size = int64_t{1} << level;
    line = (line + size - 1) & -size;
    const int64_t number = (sign_ > 0 ? line : -line) >> level;
    if (number < 0 || number >= levels[level].lines[along]) return;
    const double ahead = static_cast<double>(line) - reference_.x;
    if (ahead * bin_ <= HorizonLine::kMostStep * static_cast<double>(size))
      lines_.push_back({level, static_cast<uint32_t>(number), static_cast<float>(ahead)});
    line += std::max<int64_t>(1, static_cast<int64_t>(kLineStep * ahead) >> level) << level;
  }
}

HorizonSide::Reach HorizonSide::reachOf(uint32_t segment) const {
  Reach reach{tangentOf(segment * kBins), tangentOf((segment + 1) * kBins), 0, 0};
  for (const double tangent : {reach.first, reach.last})
    for (const double aside : {tangent * ball_, back_.y - tangent * back_.x}) {
      reach.low = std::min(reach.low, aside - ball_ * (1 + std::fabs(tangent)));
      reach.high = std::max(reach.high, aside + ball_ * (1 + std::fabs(tangent)));
    }
  return reach;
}

// Finds the least heights about the bins of a segment on a line; false if the line is so near that these would be too
// many bins.
bool HorizonSide::cut(const Line& line, const Reach& reach, HorizonLine& cut) const {
  const double width = line.ahead * bin_;  // of a bin, steps
  const double below = std::floor(reach.low / width), above = std::ceil(reach.high / width);
  if (above - below > HorizonLine::kMostHalo) return false;
  const HorizonGrid::Level& level = grid_->levels()[line.level];
  const double size = 1u << line.level;
  const auto halo = static_cast<int>(above - below);
  cut.findLeast({level.line(along_, line.number), static_cast<int>(level.vertices[static_cast<size_t>(along_)])},
                static_cast<float>((reference_.y + line.ahead * (reach.first + below * bin_)) / size),
                static_cast<float>(width / size), static_cast<int>(kBins) + halo);
  cut.widen(halo);
  return true;
}

void HorizonSide::prefetch(const Line& line, const Reach& reach) const {
  const HorizonGrid::Level& level = grid_->levels()[line.level];
  const double size = 1u << line.level;
  const uint16_t* const heights = level.line(along_, line.number);
  const auto vertex = [&](double aside, double tangent) {
    const double v = (reference_.y + aside + line.ahead * tangent) / size;
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(level.vertices[static_cast<size_t>(along_)])));
  };
  constexpr int kHeightsOfCacheLine = 32;
  const int last = vertex(reach.high, reach.last);
  for (int v = vertex(reach.low, reach.first); v < last; v += kHeightsOfCacheLine) __builtin_prefetch(heights + v);
}

// Whether nothing farther away can be seen.
bool HorizonSide::isClosed(const std::array<float, kBins>& slopes, float ahead) const {
  constexpr double kSpare = 0.002;  // for tolerances
  const auto enough =
      static_cast<float>(std::max(grid_->highest() - eye_m_, 0.0) / ahead + kSpare * grid_->metresOfStep());
  return *std::min_element(slopes.begin(), slopes.end()) > enough;
}

void HorizonSide::build(uint32_t number) {
  constexpr size_t kCloseTests = 8;  // distances between two
  ++built_;
  Segment& segment = segments_[number];
  const Reach reach = reachOf(number);
  std::array<float, kBins> slopes;
  slopes.fill(HorizonLine::kNone);
  size_t kept = 0;
  const auto keep = [&] {
    segment.resize(++kept * kBins);
    HorizonLine::round(slopes, slopes_of_step_, &segment[(kept - 1) * kBins]);
  };
  const HorizonGrid::Steps& steps = grid_->steps();
  const auto eye = static_cast<float>(steps.of(eye_m_));
  HorizonLine heights;
  for (size_t i = 0; i < lines_.size(); ++i) {
    const Line& line = lines_[i];
    if (i + kPrefetch < lines_.size()) prefetch(lines_[i + kPrefetch], reach);
    for (; distanceOf(kept) <= line.ahead; keep())
      if (kept % kCloseTests == 0 && isClosed(slopes, line.ahead)) return keep();
    if (cut(line, reach, heights))
      heights.raise(eye, static_cast<float>(steps.step_m / (line.ahead + depth_)),
                    static_cast<float>(steps.step_m / line.ahead), slopes);
  }
  keep();
}

int HorizonSide::slope(uint32_t bin, double ahead) {
  Segment& segment = segments_[bin / kBins];
  if (segment.empty()) build(bin / kBins);
  const size_t distance = std::min<size_t>(distanceNumber(ahead), segment.size() / kBins - 1);
  return segment[distance * kBins + bin % kBins];
}

size_t HorizonSide::bytes() const {
  size_t bytes = lines_.capacity() * sizeof(Line) + segments_.capacity() * sizeof(Segment);
  for (const Segment& segment : segments_) bytes += segment.capacity() * sizeof(int16_t);
  return bytes;
}

}  // namespace foreland::server
