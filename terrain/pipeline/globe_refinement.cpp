#include "terrain/pipeline/globe_refinement.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "proto/section/page_directory.h"
#include "terrain/parallel.h"
#include "terrain/pipeline/globe_triangles.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;
using proto::Slot;

// What one thread finds.
class Refinement {
 public:
  Refinement(double residual_m, const GlobeSource& source, const proto::GridTopology& grid, const proto::Frame& frame)
      : residual_m_(residual_m), source_(source), grid_(grid), places_(grid), transform_(frame) {}

  void addRow(size_t input, uint32_t row, int deepest) {
    positions_.clear();
    samples_.clear();
    source_.samplesOf(input, row, samples_);
    for (const GlobeSample& sample : samples_) add(sample.direction, static_cast<int>(input), deepest);
  }
  const std::unordered_set<Slot>& pages() const { return pages_; }

 private:
  void add(const glm::dvec3& direction, int input, int deepest) {
    const GlobeHeight ground = source_.heightAt(direction);
    if (ground.owner != input && ground.owner != GlobeHeight::kMixed) return;
    const GlobePlaces::Place at = places_.placeOf(direction);
    BisectionTriangle t = places_.coarsest(at);
    std::optional<Slot> last;
    for (int level = 1; level <= deepest; ++level) {
      if (level > grid_.wholeLevels() && std::fabs(heightOf(t, at) - ground.metres) > residual_m_)
        last = grid_.slot(places_.nameOf(at.face, t.middle()), level);
      t = t.halfWith(at.p);
    }
    if (last) pages_.insert(*last - *last % proto::kPageSlots);
  }

  double heightOf(const BisectionTriangle& t, const GlobePlaces::Place& at) {
    const auto share = t.sharesAt(at.p);
    const glm::dvec3 drawn = share[0] * positionOf(at.face, t.a) + share[1] * positionOf(at.face, t.b) +
                             share[2] * positionOf(at.face, t.apex);
    return transform_.spheroid().place(drawn).height_m;
  }

  glm::dvec3 positionOf(uint32_t face, glm::ivec2 p) {
    const NodeId name = places_.nameOf(face, p);
    const auto [known, is_new] = positions_.try_emplace(name);
    if (is_new)
      known->second =
          transform_.vertexOfGlobe(name.x(), name.y(), source_.heightAt(places_.directionOf(face, p)).metres);
    return known->second;
  }

  double residual_m_;
  const GlobeSource& source_;
  const proto::GridTopology& grid_;
  GlobePlaces places_;
  proto::FrameTransform transform_;
  std::vector<GlobeSample> samples_;                  // of a row
  std::unordered_map<NodeId, glm::dvec3> positions_;  // around it
  std::unordered_set<Slot> pages_;
};

}  // namespace

std::optional<std::vector<Slot>> pagesWithin(double residual_m, const GlobeSource& source,
                                             const proto::GridTopology& grid, const proto::Frame& frame,
                                             std::span<const int> deepest, unsigned threads,
                                             const std::function<bool(double)>& keepGoing) {
  std::vector<Refinement> workers;
  for (unsigned i = 0; i < threadCount(threads); ++i) workers.emplace_back(residual_m, source, grid, frame);
  const size_t insets = source.info().inputs.size() - 1;
  std::vector<std::pair<size_t, uint32_t>> rows;
  for (size_t i = 0; i < insets; ++i)
    for (uint32_t row = 0; row < source.rowsOf(i); ++row) rows.emplace_back(i, row);
  const auto addRow = [&](uint64_t at, unsigned worker) {
    const auto& [input, row] = rows[at];
    workers[worker].addRow(input, row, deepest[input]);
  };
  const auto progress = [&](uint64_t done) {
    return keepGoing(static_cast<double>(done) / static_cast<double>(rows.size()));
  };
  if (!parallelFor(rows.size(), threads, addRow, progress)) return std::nullopt;
  std::unordered_set<Slot> all;
  for (const Refinement& worker : workers) all.insert(worker.pages().begin(), worker.pages().end());
  std::vector<Slot> pages(all.begin(), all.end());
  std::ranges::sort(pages);
  return pages;
}

}  // namespace foreland::terrain
