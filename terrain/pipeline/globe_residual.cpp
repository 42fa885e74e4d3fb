#include "terrain/pipeline/globe_residual.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec2.hpp>
#include <utility>

#include "proto/space/cube_map.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;

// A triangle that is halved between a and b, on a face's square.
struct FaceTriangle {
  glm::ivec2 a, b, apex;

  // The half with a point in it.
  FaceTriangle halfWith(glm::dvec2 p) const {
    const glm::ivec2 m = (a + b) / 2;
    // On which side of the line from the middle to the apex, along the edge from a to b.
    const glm::dvec2 along = b - a, off = p - glm::dvec2(m);
    return along.x * off.x + along.y * off.y < 0 ? FaceTriangle{a, apex, m} : FaceTriangle{apex, b, m};
  }
};

class Comparison {
 public:
  Comparison(const GlobeSource& source, const proto::GridTopology& grid, const proto::Frame& frame,
             const proto::PageDirectory& pages, const std::function<int32_t(NodeId)>& height)
      : source_(source), grid_(grid), transform_(frame), pages_(pages), height_(height) {}

  // Nothing where the input does not count alone.
  std::optional<double> differenceAt(const GlobeSample& sample, int input) const {
    if (source_.heightAt(sample.direction).owner != input) return std::nullopt;
    const proto::CubePoint at = proto::cubePoint(sample.direction);
    const double half = 0.5 * grid_.rootSize();
    const glm::dvec2 p((at.s + 1) * half, (at.t + 1) * half);
    const FaceTriangle t = finestAround(at.face, p);
    glm::dvec3 drawn(0);
    const auto share = sharesOf(t, p);
    for (const auto& [corner, weight] :
         {std::pair(t.a, share[0]), std::pair(t.b, share[1]), std::pair(t.apex, share[2])}) {
      const NodeId name = nameOf(at.face, corner);
      if (source_.heightAt(directionOf(at.face, corner)).owner != input) return std::nullopt;
      drawn +=
          weight * transform_.vertexOfGlobe(name.x(), name.y(), height_(name) * transform_.frame().height_quantum_m);
    }
    return std::fabs(transform_.spheroid().place(drawn).height_m - sample.metres);
  }

 private:
  NodeId nameOf(uint32_t face, glm::ivec2 p) const { return grid_.cube().name({face, p.x, p.y}); }
  glm::dvec3 directionOf(uint32_t face, glm::ivec2 p) const {
    const double step = 2.0 / grid_.rootSize();
    return proto::cubeVector({face, p.x * step - 1, p.y * step - 1});
  }

  FaceTriangle finestAround(uint32_t face, glm::dvec2 p) const {
    const int w = static_cast<int>(grid_.rootSize());
    const glm::dvec2 off = p - 0.5 * w;
    const glm::ivec2 corners[] = {{0, 0}, {w, 0}, {w, w}, {0, w}};
    const int side = std::fabs(off.x) > std::fabs(off.y) ? (off.x > 0 ? 1 : 3) : (off.y > 0 ? 2 : 0);
    FaceTriangle t{corners[side], corners[(side + 1) % 4], glm::ivec2(w / 2)};
    for (int level = 1; level <= grid_.maxLevel(); ++level) {
      if (!pages_.hasPage(grid_.slot(nameOf(face, (t.a + t.b) / 2), level))) break;
      t = t.halfWith(p);
    }
    return t;
  }

  static std::array<double, 3> sharesOf(const FaceTriangle& t, glm::dvec2 p) {
    const auto area = [](glm::dvec2 u, glm::dvec2 v) { return u.x * v.y - u.y * v.x; };
    const glm::dvec2 a(t.a), b(t.b), c(t.apex);
    const double all = area(b - a, c - a), at_b = area(p - a, c - a) / all, at_c = area(b - a, p - a) / all;
    return {1 - at_b - at_c, at_b, at_c};
  }

  const GlobeSource& source_;
  const proto::GridTopology& grid_;
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
