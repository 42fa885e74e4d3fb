#include "server/occlusion/horizon/horizon_side.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace foreland::server {

namespace {

constexpr double kLineStep = 0.008;     // between two lines, of their distance
constexpr double kMaxSlope = 2;         // that is kept: metres per metre
constexpr uint32_t kDistancesLog2 = 4;  // of distances between two powers of two

// Slopes are kept for distances that are evenly spread between powers of two: the first bits of a float are their
// numbers.
constexpr uint32_t kShift = 23 - kDistancesLog2;
constexpr uint32_t kFirst = std::bit_cast<uint32_t>(static_cast<float>(HorizonSide::kNearest)) >> kShift;
uint32_t distanceNumber(double ahead) {
  return (std::bit_cast<uint32_t>(static_cast<float>(ahead)) >> kShift) - kFirst;
}
float distanceOf(size_t number) { return std::bit_cast<float>((static_cast<uint32_t>(number) + kFirst) << kShift); }

}  // namespace

// The reference is the capsule's end that is farther ahead, and by the ball's radius farther.
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
  slopes_of_step_ = static_cast<float>(std::numeric_limits<int16_t>::max() / (kMaxSlope * grid.metresOfStep()));
  segments_.resize(static_cast<size_t>(std::ceil(2 * kMaxTangent / bin / kBins)));
  kept_bytes_ = 0;
  for (Segment& segment : segments_) {
    segment.kept.clear();
    segment.is_whole = false;
    kept_bytes_ += segment.kept.capacity() * sizeof(int16_t);
  }
  findLines();
}

// Farther away, lines are left out, and those of coarser levels are taken, where a bin is wider than the vertices of a
// finer one are apart.
void HorizonSide::findLines() {
  lines_.clear();
  const auto& levels = grid_->levels();
  const auto along = static_cast<size_t>(along_);
  const double first = std::max(std::floor(reference_.x) + 1, sign_ > 0 ? 0.0 : 1.0 - levels[0].lines[along]);
  // Over globes heights have room for what bins are wide where the farthest eyes see the line.
  const double from = reference_.x - (grid_->isOverGlobe() ? depth_ : 0);
  uint32_t level = 0;
  for (auto line = static_cast<int64_t>(first);;) {
    while (level < levels.size() && (static_cast<double>(line) - from) * bin_ > HorizonLine::kMaxStep * (1u << level))
      ++level;
    if (level == levels.size()) return;
    const int64_t size = int64_t{1} << level;
    line = (line + size - 1) & -size;
    const int64_t number = (sign_ > 0 ? line : -line) >> level;
    if (number < 0 || number >= levels[level].lines[along]) return;
    const double ahead = static_cast<double>(line) - reference_.x;
    if ((static_cast<double>(line) - from) * bin_ <= HorizonLine::kMaxStep * static_cast<double>(size))
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

HorizonSide::Cut HorizonSide::cutOf(const Line& line, const Reach& reach) const {
  const double width = line.ahead * bin_;  // of a bin, steps
  const double below = std::floor(reach.low / width), halo = std::ceil(reach.high / width) - below;
  const HorizonGrid::Level& level = grid_->levels()[line.level];
  const double vertices = 1.0 / (1u << line.level);  // in a step
  return {{level.line(along_, line.number), static_cast<int>(level.vertices[static_cast<size_t>(along_)])},
          static_cast<float>((reference_.y + line.ahead * (reach.first + below * bin_)) * vertices),
          static_cast<float>(width * vertices),
          static_cast<int>(std::min(halo, HorizonLine::kMaxHalo + 1.0))};
}

// Whether nothing farther away can be seen.
bool HorizonSide::isClosed(const std::array<float, kBins>& slopes, float ahead) const {
  constexpr double kSpare = 0.002;  // for tolerances
  const auto enough =
      static_cast<float>(std::max(grid_->highest() - eye_m_, 0.0) / ahead + kSpare * grid_->metresOfStep());
  return *std::min_element(slopes.begin(), slopes.end()) > enough;
}

void HorizonSide::keep(Segment& segment) {
  const size_t size = segment.kept.size(), capacity = segment.kept.capacity();
  segment.kept.resize(size + kBins);
  kept_bytes_ += (segment.kept.capacity() - capacity) * sizeof(int16_t);
  HorizonLine::round(segment.slopes, slopes_of_step_, &segment.kept[size]);
}

// Goes on until the segment holds the slopes for a distance or is whole.
void HorizonSide::build(uint32_t number, size_t distance) {
  constexpr size_t kCloseTests = 8;  // distances between two
  constexpr size_t kAhead = 8;       // lines whose heights wait for memory together
  Segment& segment = segments_[number];
  if (segment.kept.empty()) {
    ++built_;
    segment.slopes.fill(HorizonLine::kNone);
    segment.lines = 0;
  }
  const Reach reach = reachOf(number);
  std::array<Cut, kAhead> cuts;
  size_t known = segment.lines;
  const auto lookAhead = [&](size_t end) {
    for (; known < std::min(end, lines_.size()); ++known) {
      const Cut& cut = cuts[known % kAhead] = cutOf(lines_[known], reach);
      HorizonLine::prefetch(cut.vertices, cut.first, cut.step, static_cast<int>(kBins) + cut.halo);
    }
  };
  const HorizonGrid::Steps& steps = grid_->steps();
  const auto eye = static_cast<float>(steps.of(eye_m_));
  HorizonLine heights;
  for (size_t i = segment.lines; i < lines_.size(); ++i) {
    const Line& line = lines_[i];
    for (; distanceOf(segment.distances()) <= line.ahead; keep(segment)) {
      segment.is_whole = segment.distances() % kCloseTests == 0 && isClosed(segment.slopes, line.ahead);
      if (segment.is_whole) return keep(segment);
      if (segment.distances() > distance) {
        segment.lines = static_cast<uint32_t>(i);
        return;
      }
    }
    lookAhead(i + kAhead);
    const Cut& cut = cuts[i % kAhead];
    if (cut.isNear()) continue;
    heights.findLeast(cut.vertices, cut.first, cut.step, static_cast<int>(kBins) + cut.halo);
    heights.widen(cut.halo);
    heights.raise(eye, static_cast<float>(steps.step_m / (line.ahead + depth_)),
                  static_cast<float>(steps.step_m / line.ahead), segment.slopes);
  }
  segment.is_whole = true;
  keep(segment);
}

int HorizonSide::slope(uint32_t bin, double ahead) {
  Segment& segment = segments_[bin / kBins];
  size_t distance = distanceNumber(ahead);
  if (distance >= segment.distances()) {
    if (!segment.is_whole) build(bin / kBins, distance);
    distance = std::min(distance, segment.distances() - 1);
  }
  return segment.kept[distance * kBins + bin % kBins];
}

size_t HorizonSide::bytes() const {
  return lines_.capacity() * sizeof(Line) + segments_.capacity() * sizeof(Segment) + kept_bytes_;
}

}  // namespace foreland::server
