#include "oracle/oracle.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>

#include "oracle/block_raster.h"
#include "oracle/epoch_shares.h"

namespace foreland::oracle {

namespace {

struct Sphere {
  glm::dvec3 centre{0};
  double radius = 0;
};

// What projecting needs, computed once per frame.
struct Camera {
  glm::dvec3 eye, right, up, back;
  double focal_px, half_width_px, half_height_px, near_m;

  Camera(const proto::Pose& pose, const proto::Lens& lens, double near)
      : eye(pose.eye),
        right(pose.right()),
        up(pose.up()),
        back(-pose.forward()),
        focal_px(lens.focalPx()),
        half_width_px(0.5 * lens.width_px),
        half_height_px(0.5 * lens.height_px),
        near_m(near) {}

  bool maySee(const Sphere& s) const {
    const glm::dvec3 d = s.centre - eye;
    const double depth = -glm::dot(back, d);
    if (depth < near_m - s.radius) return false;
    return isWithin(std::fabs(glm::dot(right, d)), depth, half_width_px, s.radius) &&
           isWithin(std::fabs(glm::dot(up, d)), depth, half_height_px, s.radius);
  }

 private:
  // Signed distance to the frustum's side plane at most the radius.
  bool isWithin(double across, double depth, double half_px, double radius) const {
    return across * focal_px - depth * half_px <= radius * std::hypot(focal_px, half_px);
  }
};

struct HeightBlock {
  std::vector<double> heights;  // kBlock * kBlock, unused beyond the data; empty until first needed
  Sphere bound;                 // of the true positions
};

struct Row {
  std::array<double, kBlock> x, y, z;
};

}  // namespace

struct Oracle::Impl {
  Truth truth;
  double near_m;
  proto::FrameGrid grid;
  uint32_t blocks_x, blocks_y;
  std::vector<HeightBlock> blocks;
  std::vector<int32_t> rank;
  std::vector<uint32_t> seen;
  std::vector<std::vector<TriangleBins>> bins;  // of each surface, of each of its shares
  std::vector<Tile> tiles;                      // of each surface
  TruthTime time;
  std::vector<double> epoch_shares;  // at `time`, by epoch

  Impl(Truth t, double near)
      : truth(std::move(t)),
        near_m(near),
        grid(truth.frame, truth.shape.samples_x - 1, truth.shape.samples_y - 1),
        blocks_x((truth.shape.samples_x + kBlock - 1) >> kBlockLog2),
        blocks_y((truth.shape.samples_y + kBlock - 1) >> kBlockLog2),
        blocks(static_cast<size_t>(blocks_x) * blocks_y),
        rank(blocks.size()) {}

  uint32_t columns(uint32_t bx) const { return std::min(kBlock, truth.shape.samples_x - bx * kBlock); }
  uint32_t rows(uint32_t by) const { return std::min(kBlock, truth.shape.samples_y - by * kBlock); }

  glm::dvec3 truePosition(const HeightBlock& block, uint32_t bx, uint32_t by, uint32_t x, uint32_t y) const {
    return grid.position(proto::NodeId::at(bx * kBlock + x, by * kBlock + y), block.heights[y * kBlock + x]);
  }

  bool mayMove(uint32_t bx, uint32_t by) const {
    const proto::LatticeWindow& w = truth.moved;
    return w.x < (bx + 1) * kBlock && bx * kBlock < w.x + w.width && w.y < (by + 1) * kBlock &&
           by * kBlock < w.y + w.height;
  }

  void readRow(uint32_t bx, uint32_t y, double* out) {
    std::array<int32_t, kBlock> heights;
    truth.heights(bx * kBlock, y, std::span(heights).first(columns(bx)));
    std::copy_n(heights.begin(), columns(bx), out);
    if (!mayMove(bx, y / kBlock)) return;
    std::array<double, kBlock> offsets;
    for (size_t epoch = 0; epoch < epoch_shares.size(); ++epoch) {
      if (epoch_shares[epoch] == 0) continue;
      truth.offsets(epoch, bx * kBlock, y, std::span(offsets).first(columns(bx)));
      for (uint32_t x = 0; x < columns(bx); ++x) out[x] += epoch_shares[epoch] * offsets[x];
    }
  }

  void addEpochs(Time at, double share) {
    const std::vector<double> shares = epochShares(truth.epochs, truth.blend, at);
    for (size_t i = 0; i < shares.size(); ++i) epoch_shares[i] += share * shares[i];
  }

  void showAt(const TruthTime& wanted) {
    if (truth.epochs.empty() || (wanted == time && !epoch_shares.empty())) return;
    time = wanted;
    epoch_shares.assign(truth.epochs.size(), 0);
    const Time first = std::min(wanted.from, wanted.to), last = std::max(wanted.from, wanted.to);
    const bool is_step =
        truth.blend == proto::EpochBlend::kLinear
            ? std::none_of(truth.epochs.begin(), truth.epochs.end(), [&](Time t) { return first < t && t < last; })
            : wanted.is_step;
    if (is_step) {
      addEpochs({wanted.from.us + std::llround(wanted.weight * static_cast<double>((wanted.to - wanted.from).us))}, 1);
    } else {
      addEpochs(wanted.from, 1 - wanted.weight);
      addEpochs(wanted.to, wanted.weight);
    }
    for (uint32_t by = 0; by < blocks_y; ++by)
      for (uint32_t bx = 0; bx < blocks_x; ++bx)
        if (mayMove(bx, by)) blocks[static_cast<size_t>(by) * blocks_x + bx] = {};
  }

  // Reads a block's heights and bounds it, once.
  const HeightBlock& load(uint32_t bx, uint32_t by) {
    HeightBlock& block = blocks[static_cast<size_t>(by) * blocks_x + bx];
    if (!block.heights.empty()) return block;
    block.heights.resize(kBlock * kBlock);
    for (uint32_t y = 0; y < rows(by); ++y) readRow(bx, by * kBlock + y, &block.heights[y * kBlock]);
    block.bound.centre = truePosition(block, bx, by, columns(bx) / 2, rows(by) / 2);
    for (uint32_t y = 0; y < rows(by); ++y)
      for (uint32_t x = 0; x < columns(bx); ++x)
        block.bound.radius =
            std::max(block.bound.radius, glm::distance(block.bound.centre, truePosition(block, bx, by, x, y)));
    return block;
  }

  // All blocks are loaded by the first frame: culling needs their true bounds, and a bound from anything less would
  // have to be believed.
  void chooseBlocks(const Camera& camera) {
    seen.clear();
    for (uint32_t by = 0; by < blocks_y; ++by)
      for (uint32_t bx = 0; bx < blocks_x; ++bx) {
        const uint32_t index = by * blocks_x + bx;
        const bool may_see = camera.maySee(load(bx, by).bound);
        rank[index] = may_see ? static_cast<int32_t>(seen.size()) : -1;
        if (may_see) seen.push_back(index);
      }
  }

  void bin(Surface surface, std::vector<TriangleBins>& out) {
    out.resize(std::max(out.size(), surface.size()));
    for (size_t i = 0; i < surface.size(); ++i) out[i].build(*surface[i].mesh, rank, blocks_x, blocks_y, seen.size());
  }

  void fill(Surface surface, const std::vector<TriangleBins>& of_shares, size_t k, Tile& tile) {
    for (auto& component : tile.position) component.fill(0);
    tile.covered.fill(~0u);
    std::array<uint32_t, kBlock> covered;
    for (size_t i = 0; i < surface.size(); ++i) {
      rasterise(*surface[i].mesh, surface[i].weight, surface[i].share, of_shares[i].triangles(k), seen[k] % blocks_x,
                seen[k] / blocks_x, tile, covered);
      for (uint32_t y = 0; y < kBlock; ++y) tile.covered[y] &= covered[y];
    }
  }

  void judgeBlock(size_t k, const Camera& camera, std::span<const SurfacePair> pairs, std::span<Deviation> sums);
  static void finish(Deviation& d);
};

namespace {

struct RowErrors {
  std::array<double, kBlock> px2, m2;
  std::array<uint8_t, kBlock> is_seen;
};

// Distance on the screen and in space between `a` and `b`, where `truth` is seen. Written for the compiler to
// vectorise.
void judgeRow(const Camera& camera, const Row& truth, const Row& a, const Row& b, RowErrors& out) {
  const double nearest = 0.01 * camera.near_m;  // a drawn point behind the eye counts as very near, hence as very wrong
  for (uint32_t i = 0; i < kBlock; ++i) {
    const auto across = [&](const Row& r, const glm::dvec3& axis) {
      return axis.x * (r.x[i] - camera.eye.x) + axis.y * (r.y[i] - camera.eye.y) + axis.z * (r.z[i] - camera.eye.z);
    };
    const double depth = -across(truth, camera.back);
    const double reach = depth / camera.focal_px;
    const int ahead = depth > camera.near_m;
    const int within_width = std::fabs(across(truth, camera.right)) <= reach * camera.half_width_px;
    const int within_height = std::fabs(across(truth, camera.up)) <= reach * camera.half_height_px;
    out.is_seen[i] = static_cast<uint8_t>(ahead & within_width & within_height);  // `&&` would branch
    const double scale_a = camera.focal_px / std::max(nearest, -across(a, camera.back));
    const double scale_b = camera.focal_px / std::max(nearest, -across(b, camera.back));
    const double dx = scale_a * across(a, camera.right) - scale_b * across(b, camera.right);
    const double dy = scale_a * across(a, camera.up) - scale_b * across(b, camera.up);
    const double mx = a.x[i] - b.x[i], my = a.y[i] - b.y[i], mz = a.z[i] - b.z[i];
    out.px2[i] = dx * dx + dy * dy;
    out.m2[i] = mx * mx + my * my + mz * mz;
  }
}

Row rowOf(const Tile& tile, uint32_t y) {
  Row row;
  std::copy_n(tile.position[0].begin() + y * kBlock, kBlock, row.x.begin());
  std::copy_n(tile.position[1].begin() + y * kBlock, kBlock, row.y.begin());
  std::copy_n(tile.position[2].begin() + y * kBlock, kBlock, row.z.begin());
  return row;
}

}  // namespace

namespace {

void addRow(const RowErrors& errors, uint32_t covered, glm::uvec2 first, uint32_t columns, Deviation& sums) {
  for (uint32_t x = 0; x < columns; ++x) {
    if (!errors.is_seen[x]) continue;
    if (!(covered >> x & 1)) {
      ++sums.uncovered;
      continue;
    }
    ++sums.samples;
    sums.rms_px += errors.px2[x];
    sums.rms_m += errors.m2[x];
    sums.max_m = std::max(sums.max_m, errors.m2[x]);
    if (errors.px2[x] <= sums.max_px) continue;
    sums.max_px = errors.px2[x];
    sums.worst_sample = {first.x + x, first.y};
  }
}

}  // namespace

// Sums squares into rms_*, and squares of the largest into max_*; finish() takes the roots.
void Oracle::Impl::judgeBlock(size_t k, const Camera& camera, std::span<const SurfacePair> pairs,
                              std::span<Deviation> sums) {
  const uint32_t bx = seen[k] % blocks_x, by = seen[k] / blocks_x;
  const HeightBlock& block = load(bx, by);
  Row truth_row{};
  RowErrors errors;
  for (uint32_t y = 0; y < rows(by); ++y) {
    for (uint32_t x = 0; x < columns(bx); ++x) {
      const glm::dvec3 p = truePosition(block, bx, by, x, y);
      truth_row.x[x] = p.x, truth_row.y[x] = p.y, truth_row.z[x] = p.z;
    }
    for (size_t i = 0; i < pairs.size(); ++i) {
      const Tile &a = tiles[pairs[i].a], *b = pairs[i].b == SurfacePair::kTruth ? nullptr : &tiles[pairs[i].b];
      judgeRow(camera, truth_row, rowOf(a, y), b ? rowOf(*b, y) : truth_row, errors);
      addRow(errors, a.covered[y] & (b ? b->covered[y] : ~0u), {bx * kBlock, by * kBlock + y}, columns(bx), sums[i]);
    }
  }
}

void Oracle::Impl::finish(Deviation& d) {
  const double count = static_cast<double>(std::max<uint64_t>(d.samples, 1));
  d.max_px = std::sqrt(d.max_px), d.max_m = std::sqrt(d.max_m);
  d.rms_px = std::sqrt(d.rms_px / count), d.rms_m = std::sqrt(d.rms_m / count);
}

Oracle::Oracle(Truth truth, double near_m) : impl_(std::make_unique<Impl>(std::move(truth), near_m)) {}
Oracle::~Oracle() = default;
Oracle::Oracle(Oracle&&) noexcept = default;

void Oracle::showAt(const TruthTime& time) { impl_->showAt(time); }

std::span<const double> Oracle::sharesShown() const { return impl_->epoch_shares; }

std::span<const Time> Oracle::epochs() const { return impl_->truth.epochs; }

double Oracle::carriedAt(double x, double y) const {
  const Truth& truth = impl_->truth;
  x = std::clamp(x, 0.0, truth.shape.samples_x - 1.0), y = std::clamp(y, 0.0, truth.shape.samples_y - 1.0);
  double carried = 0;
  for (size_t epoch = 0; epoch < impl_->epoch_shares.size(); ++epoch) {
    double risen = 0;
    for (const double row : {std::floor(y), std::ceil(y)})
      for (const double column : {std::floor(x), std::ceil(x)}) {
        double offset = 0;
        const auto at_x = static_cast<uint32_t>(column), at_y = static_cast<uint32_t>(row);
        if (truth.moved.contains(at_x, at_y)) truth.offsets(epoch, at_x, at_y, {&offset, 1});
        const double along_x = std::floor(x) == std::ceil(x) ? 0.5 : 1 - std::fabs(x - column),
                     along_y = std::floor(y) == std::ceil(y) ? 0.5 : 1 - std::fabs(y - row);
        risen += along_x * along_y * offset;
      }
    carried += impl_->epoch_shares[epoch] * std::round(risen);
  }
  return carried;
}

Deviation Oracle::error(Surface drawn, const proto::Pose& pose, const proto::Lens& lens) {
  constexpr SurfacePair kAgainstTruth;
  return compare({&drawn, 1}, {&kAgainstTruth, 1}, pose, lens).front();
}

Deviation Oracle::difference(Surface a, Surface b, const proto::Pose& pose, const proto::Lens& lens) {
  const Surface both[] = {a, b};
  constexpr SurfacePair kEachOther{0, 1};
  return compare(both, {&kEachOther, 1}, pose, lens).front();
}

std::vector<Deviation> Oracle::compare(std::span<const Surface> surfaces, std::span<const SurfacePair> pairs,
                                       const proto::Pose& pose, const proto::Lens& lens) {
  Impl& impl = *impl_;
  const Camera camera(pose, lens, impl.near_m);
  impl.chooseBlocks(camera);
  impl.bins.resize(std::max(impl.bins.size(), surfaces.size()));
  impl.tiles.resize(std::max(impl.tiles.size(), surfaces.size()));
  for (size_t i = 0; i < surfaces.size(); ++i) impl.bin(surfaces[i], impl.bins[i]);
  std::vector<Deviation> result(pairs.size());
  for (size_t k = 0; k < impl.seen.size(); ++k) {
    for (size_t i = 0; i < surfaces.size(); ++i) impl.fill(surfaces[i], impl.bins[i], k, impl.tiles[i]);
    impl.judgeBlock(k, camera, pairs, result);
  }
  for (Deviation& d : result) impl.finish(d);
  return result;
}

}  // namespace foreland::oracle
