#include "terrain/pipeline/globe_residual.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "terrain/parallel.h"
#include "terrain/pipeline/globe_triangles.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;

class Comparison {
 public:
  Comparison(const GlobeSource& source, const proto::GridTopology& grid, const proto::Frame& frame,
             const proto::PageDirectory& pages, const std::function<int32_t(NodeId)>& height)
      : source_(source), grid_(grid), places_(grid), transform_(frame), pages_(pages), height_(height) {}

  // Nothing where the input does not count alone.
  std::optional<double> differenceAt(const GlobeSample& sample, int input) const {
    if (source_.heightAt(sample.direction).owner != input) return std::nullopt;
    const GlobePlaces::Place at = places_.placeOf(sample.direction);
    const BisectionTriangle t = finestAround(at);
    glm::dvec3 drawn(0);
    const auto share = t.sharesAt(at.p);
    for (const auto& [corner, weight] :
         {std::pair(t.a, share[0]), std::pair(t.b, share[1]), std::pair(t.apex, share[2])}) {
      const NodeId name = places_.nameOf(at.face, corner);
      if (source_.heightAt(places_.directionOf(at.face, corner)).owner != input) return std::nullopt;
      drawn +=
          weight * transform_.vertexOfGlobe(name.x(), name.y(), height_(name) * transform_.frame().height_quantum_m);
    }
    return std::fabs(transform_.spheroid().place(drawn).height_m - sample.metres);
  }

 private:
  BisectionTriangle finestAround(const GlobePlaces::Place& at) const {
    BisectionTriangle t = places_.coarsest(at);
    for (int level = 1; level <= grid_.maxLevel(); ++level) {
      if (level > grid_.wholeLevels() && !pages_.hasPage(grid_.slot(places_.nameOf(at.face, t.middle()), level))) break;
      t = t.halfWith(at.p);
    }
    return t;
  }

  const GlobeSource& source_;
  const proto::GridTopology& grid_;
  GlobePlaces places_;
  proto::FrameTransform transform_;
  const proto::PageDirectory& pages_;
  const std::function<int32_t(NodeId)>& height_;
};

}  // namespace

std::optional<std::vector<double>> globeResiduals(const GlobeSource& source, const proto::GridTopology& grid,
                                                  const proto::Frame& frame, const std::vector<proto::Slot>& pages,
                                                  const std::function<int32_t(NodeId)>& height, unsigned threads,
                                                  const std::function<bool(double)>& keepGoing) {
  const std::vector<proto::PageBlock> blocks = proto::blocksOf(grid, pages);
  const auto directory = proto::PageDirectory::create(grid, blocks);
  CHECK_TRUE(directory.ok());
  const Comparison comparison(source, grid, frame, *directory, height);
  std::vector<double> largest_m;
  uint64_t all_rows = 0, done_rows = 0;
  for (size_t i = 0; i < source.info().inputs.size(); ++i) all_rows += source.rowsOf(i);
  for (size_t i = 0; i < source.info().inputs.size(); ++i) {
    std::vector<double> of_row(source.rowsOf(i));
    const auto compareRow = [&](uint64_t row, unsigned) {
      std::vector<GlobeSample> samples;
      source.samplesOf(i, static_cast<uint32_t>(row), samples);
      for (const GlobeSample& sample : samples)
        if (const auto off_m = comparison.differenceAt(sample, static_cast<int>(i)))
          of_row[row] = std::max(of_row[row], *off_m);
    };
    const auto progress = [&](uint64_t done) {
      return keepGoing(static_cast<double>(done_rows + done) / static_cast<double>(all_rows));
    };
    if (!parallelFor(of_row.size(), threads, compareRow, progress)) return std::nullopt;
    done_rows += of_row.size();
    largest_m.push_back(*std::ranges::max_element(of_row));
  }
  return largest_m;
}

}  // namespace foreland::terrain
