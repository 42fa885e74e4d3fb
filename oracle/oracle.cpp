#include "oracle/oracle.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>
#include <mutex>
#include <utility>

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
  double focal_px, half_width_px, half_height_px, near_m, stretched;

  Camera(const proto::Pose& pose, const proto::Lens& lens, double near, const Stretch& stretch)
      : eye(pose.eye),
        right(stretch(pose.right())),
        up(stretch(pose.up())),
        back(-stretch(pose.forward())),
        focal_px(lens.focalPx()),
        half_width_px(0.5 * lens.width_px),
        half_height_px(0.5 * lens.height_px),
        near_m(near),
        stretched(stretch.largest()) {}

  bool maySee(const Sphere& s) const {
    const glm::dvec3 d = s.centre - eye;
    const double depth = -glm::dot(back, d), radius = stretched * s.radius;
    if (depth < near_m - radius) return false;
    return isWithin(std::fabs(glm::dot(right, d)), depth, half_width_px, radius) &&
           isWithin(std::fabs(glm::dot(up, d)), depth, half_height_px, radius);
  }

 private:
  // Signed distance to the frustum's side plane at most the radius.
  bool isWithin(double across, double depth, double half_px, double radius) const {
    return across * focal_px - depth * half_px <= radius * std::hypot(focal_px, half_px);
  }
};

// The samples of kBlock rows and columns.
struct HeightBlock {
  std::vector<double> heights;        // kBlock * kBlock, unused beyond the data; empty until first needed
  std::vector<glm::dvec3> positions;  // likewise, if the frame does not say them; not numbers where no sample is
  Sphere bound;                       // of the true positions
};

struct Row {
  std::array<double, kBlock> x, y, z;
};
struct ScreenRow {
  std::array<double, kBlock> x, y;
};

}  // namespace

// The truth, and the blocks of it that no epoch moves. Immutable once it is loaded, and then shared by twins.
struct Oracle::Ground {
  Truth truth;
  proto::FrameGrid grid;
  uint32_t blocks_x, blocks_y;
  std::vector<HeightBlock> still;  // by block; empty where the ground moves
  std::once_flag loaded;           // threads that judge pieces of a flight share the ground

  explicit Ground(Truth t)
      : truth(std::move(t)),
        grid(truth.frame, truth.shape.samples_x - 1, truth.shape.samples_y - 1),
        blocks_x((truth.shape.samples_x + kBlock - 1) >> kBlockLog2),
        blocks_y((truth.shape.samples_y + kBlock - 1) >> kBlockLog2) {}

  size_t blockCount() const { return static_cast<size_t>(blocks_x) * blocks_y; }
  uint32_t columns(size_t block) const {
    return std::min(kBlock, truth.shape.samples_x - static_cast<uint32_t>(block % blocks_x) * kBlock);
  }
  uint32_t rows(size_t block) const {
    return std::min(kBlock, truth.shape.samples_y - static_cast<uint32_t>(block / blocks_x) * kBlock);
  }
  glm::uvec2 firstSample(size_t block) const { return kBlock * glm::uvec2(block % blocks_x, block / blocks_x); }
  bool mayMove(size_t block) const {
    const proto::LatticeWindow& w = truth.moved;
    const glm::uvec2 first = firstSample(block);
    return w.x < first.x + kBlock && first.x < w.x + w.width && w.y < first.y + kBlock && first.y < w.y + w.height;
  }

  glm::dvec3 position(const HeightBlock& block, glm::uvec2 first, uint32_t x, uint32_t y) const {
    if (truth.position) return block.positions[y * kBlock + x];
    return grid.position(proto::NodeId::at(first.x + x, first.y + y), block.heights[y * kBlock + x]);
  }

  // With the ground moved by `epoch_shares`, which is empty where it does not move.
  HeightBlock read(size_t index, std::span<const double> epoch_shares) const {
    HeightBlock block;
    block.heights.resize(kBlock * kBlock);
    const glm::uvec2 first = firstSample(index);
    for (uint32_t y = 0; y < rows(index); ++y)
      readRow(first + glm::uvec2(0, y), epoch_shares, std::span(block.heights).subspan(y * kBlock, columns(index)));
    if (truth.position && !place(block, first, {columns(index), rows(index)})) return block;
    if (!truth.position) block.bound.centre = position(block, first, columns(index) / 2, rows(index) / 2);
    for (uint32_t y = 0; y < rows(index); ++y)
      for (uint32_t x = 0; x < columns(index); ++x)
        block.bound.radius =
            std::max(block.bound.radius, glm::distance(block.bound.centre, position(block, first, x, y)));
    return block;
  }

  // All blocks are loaded by the first frame: culling needs their true bounds, and a bound from anything less would
  // have to be believed.
  void load() {
    std::call_once(loaded, [this] { readAll(); });
  }

 private:
  // Sets the positions of samples, and the middle of these. False if there are none, which nothing may see.
  bool place(HeightBlock& block, glm::uvec2 first, glm::uvec2 size) const {
    block.positions.assign(kBlock * kBlock, glm::dvec3(std::numeric_limits<double>::quiet_NaN()));
    glm::dvec3 sum(0);
    double count = 0;
    for (uint32_t y = 0; y < size.y; ++y)
      for (uint32_t x = 0; x < size.x; ++x)
        if (const double height = block.heights[y * kBlock + x]; !std::isnan(height)) {
          const glm::dvec3 p = truth.position(first.x + x, first.y + y, height);
          block.positions[y * kBlock + x] = p;
          sum += p, ++count;
        }
    if (count == 0) {
      block = {};
      block.bound.radius = -std::numeric_limits<double>::infinity();
      return false;
    }
    block.bound.centre = sum / count;
    return true;
  }

  void readAll() {
    still.resize(blockCount());
    for (size_t i = 0; i < still.size(); ++i) {
      if (mayMove(i)) continue;
      still[i] = read(i, {});
      if (truth.is_read_on_demand) still[i] = {.heights = {}, .positions = {}, .bound = still[i].bound};
    }
  }

  void readRow(glm::uvec2 first, std::span<const double> epoch_shares, std::span<double> out) const {
    std::array<int32_t, kBlock> heights;
    truth.heights(first.x, first.y, std::span(heights).first(out.size()));
    std::transform(
        heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(out.size()), out.begin(),
        [](int32_t h) { return h == kNoSample ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(h); });
    std::array<double, kBlock> offsets;
    for (size_t epoch = 0; epoch < epoch_shares.size(); ++epoch) {
      if (epoch_shares[epoch] == 0) continue;
      truth.offsets(epoch, first.x, first.y, std::span(offsets).first(out.size()));
      for (size_t x = 0; x < out.size(); ++x) out[x] += epoch_shares[epoch] * offsets[x];
    }
  }
};

struct Oracle::Impl {
  std::shared_ptr<Ground> ground;
  double near_m;
  Stretch stretch;
  std::vector<HeightBlock> own;  // by block, at `time`; empty where all share it, and until first needed
  size_t held = 0;               // of these, not empty
  std::vector<int32_t> rank;
  std::vector<uint32_t> seen;
  std::vector<std::vector<BlockRaster>> rasters;  // of each surface, of each of its shares
  std::vector<Tile> tiles;                        // of each surface
  std::vector<Row> drawn;                         // likewise, of the row at hand
  std::vector<ScreenRow> drawn_on_screen;
  TruthTime time;
  Sight sight;
  std::vector<double> epoch_shares;  // at `time`, by epoch

  Impl(std::shared_ptr<Ground> shared, double near)
      : ground(std::move(shared)), near_m(near), rank(ground->blockCount()) {}

  void addEpochs(Time at, double share) {
    const std::vector<double> shares = epochShares(ground->truth.epochs, ground->truth.blend, at);
    for (size_t i = 0; i < shares.size(); ++i) epoch_shares[i] += share * shares[i];
  }

  void showAt(const TruthTime& wanted) {
    const Truth& truth = ground->truth;
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
    forget();
  }

  void forget() {
    for (HeightBlock& block : own) block = {};
    held = 0;
  }

  const HeightBlock& block(size_t index) {
    const bool may_move = ground->mayMove(index);
    if (!may_move && !ground->truth.is_read_on_demand) return ground->still[index];
    own.resize(ground->blockCount());
    if (own[index].heights.empty() && own[index].bound.radius >= 0) {
      own[index] = ground->read(index, may_move ? std::span<const double>(epoch_shares) : std::span<const double>());
      ++held;
    }
    return own[index];
  }
  const Sphere& bound(size_t index) { return ground->mayMove(index) ? block(index).bound : ground->still[index].bound; }

  void chooseBlocks(const Camera& camera) {
    ground->load();
    seen.clear();
    for (uint32_t index = 0; index < rank.size(); ++index) {
      const bool may_see = camera.maySee(bound(index));
      rank[index] = may_see ? static_cast<int32_t>(seen.size()) : -1;
      if (may_see) seen.push_back(index);
    }
  }

  void build(Surface surface, std::vector<BlockRaster>& out) {
    out.resize(std::max(out.size(), surface.size()));
    for (size_t i = 0; i < surface.size(); ++i)
      out[i].build(*surface[i].mesh, surface[i].weight, surface[i].share,
                   {rank, ground->blocks_x, ground->blocks_y, seen.size()});
  }

  void fill(std::span<const BlockRaster> shares, size_t k, Tile& tile) {
    tile.position.fill({});
    tile.covered.fill(~0u);
    std::array<uint32_t, kBlock> covered;
    for (const BlockRaster& share : shares) {
      share.add(k, seen[k] % ground->blocks_x, seen[k] / ground->blocks_x, tile, covered);
      for (uint32_t y = 0; y < kBlock; ++y) tile.covered[y] &= covered[y];
    }
  }

  void judgeBlock(size_t k, size_t surfaces, const Camera& camera, std::span<const SurfacePair> pairs,
                  std::span<Deviation> sums);
  static void finish(Deviation& d);
};

namespace {

struct RowErrors {
  std::array<double, kBlock> px2, m2;
};

// The part of points' distance from the eye that is along an axis. Written for the compiler to vectorise, and so are
// those below: what they read and write is local, so that it is known not to overlap.
std::array<double, kBlock> along(glm::dvec3 axis, glm::dvec3 eye, const Row& row) {
  std::array<double, kBlock> out;
  for (uint32_t i = 0; i < kBlock; ++i)
    out[i] = axis.x * (row.x[i] - eye.x) + axis.y * (row.y[i] - eye.y) + axis.z * (row.z[i] - eye.z);
  return out;
}

// Which points the camera sees; bit x.
uint32_t seenIn(const Camera& camera, const Row& truth) {
  const auto back = along(camera.back, camera.eye, truth), right = along(camera.right, camera.eye, truth),
             up = along(camera.up, camera.eye, truth);
  const double focal_px = camera.focal_px, near_m = camera.near_m, half_width_px = camera.half_width_px,
               half_height_px = camera.half_height_px;
  std::array<uint64_t, kBlock> is_seen;
  for (uint32_t i = 0; i < kBlock; ++i) {
    const double depth = -back[i], reach = depth / focal_px;
    const int ahead = depth > near_m;
    const int within_width = std::fabs(right[i]) <= reach * half_width_px;
    const int within_height = std::fabs(up[i]) <= reach * half_height_px;
    is_seen[i] = static_cast<uint64_t>(ahead & within_width & within_height);  // `&&` would branch
  }
  uint32_t mask = 0;
  for (uint32_t i = 0; i < kBlock; ++i) mask |= static_cast<uint32_t>(is_seen[i] << i);
  return mask;
}

// Where points are on the screen, from its middle.
ScreenRow project(const Camera& camera, const Row& row) {
  const double nearest = 0.01 * camera.near_m;  // a drawn point behind the eye counts as very near, hence as very wrong
  const double focal_px = camera.focal_px;
  const auto back = along(camera.back, camera.eye, row), right = along(camera.right, camera.eye, row),
             up = along(camera.up, camera.eye, row);
  ScreenRow out;
  for (uint32_t i = 0; i < kBlock; ++i) {
    const double scale = focal_px / std::max(nearest, -back[i]);
    out.x[i] = scale * right[i];
    out.y[i] = scale * up[i];
  }
  return out;
}

// Squares of the distances on the screen and in space.
void measure(const Row& a, const ScreenRow& on_a, const Row& b, const ScreenRow& on_b, RowErrors& out) {
  for (uint32_t i = 0; i < kBlock; ++i) {
    const double dx = on_a.x[i] - on_b.x[i], dy = on_a.y[i] - on_b.y[i];
    const double mx = a.x[i] - b.x[i], my = a.y[i] - b.y[i], mz = a.z[i] - b.z[i];
    out.px2[i] = dx * dx + dy * dy;
    out.m2[i] = mx * mx + my * my + mz * mz;
  }
}

void copyRow(const Tile& tile, uint32_t y, Row& row) {
  for (uint32_t x = 0; x < kBlock; ++x) {
    const auto& position = tile.position[y * kBlock + x].at;
    row.x[x] = position[0], row.y[x] = position[1], row.z[x] = position[2];
  }
}

// Those of the samples whose errors count.
uint32_t counting(const RowErrors& errors, uint32_t samples, const Row& truth, const Sight& sight,
                  const glm::dvec3& eye) {
  if (!sight.is_seen) return samples;
  uint32_t counted = samples;
  for (uint32_t left = samples; left != 0; left &= left - 1) {
    const auto x = static_cast<uint32_t>(std::countr_zero(left));
    if (!sight.counts(std::sqrt(errors.px2[x]), {truth.x[x], truth.y[x], truth.z[x]}, eye)) counted &= ~(1u << x);
  }
  return counted;
}

void addRow(const RowErrors& errors, uint32_t seen, uint32_t covered, glm::uvec2 first, Deviation& sums) {
  sums.uncovered += static_cast<uint64_t>(std::popcount(seen & ~covered));
  sums.samples += static_cast<uint64_t>(std::popcount(seen & covered));
  for (uint32_t left = seen & covered; left != 0; left &= left - 1) {
    const auto x = static_cast<uint32_t>(std::countr_zero(left));
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
void Oracle::Impl::judgeBlock(size_t k, size_t surfaces, const Camera& camera, std::span<const SurfacePair> pairs,
                              std::span<Deviation> sums) {
  const HeightBlock& truth = block(seen[k]);
  const glm::uvec2 first = ground->firstSample(seen[k]);
  const uint32_t columns = ground->columns(seen[k]), inside = ~0u >> (kBlock - columns);
  Row true_row{};
  RowErrors errors;
  for (uint32_t y = 0; y < ground->rows(seen[k]); ++y) {
    for (uint32_t x = 0; x < columns; ++x) {
      const glm::dvec3 p = ground->position(truth, first, x, y);
      true_row.x[x] = p.x, true_row.y[x] = p.y, true_row.z[x] = p.z;
    }
    const uint32_t seen_here = seenIn(camera, true_row) & inside;
    if (seen_here == 0) continue;
    const ScreenRow true_on_screen = project(camera, true_row);
    for (size_t i = 0; i < surfaces; ++i) {
      copyRow(tiles[i], y, drawn[i]);
      drawn_on_screen[i] = project(camera, drawn[i]);
    }
    for (size_t i = 0; i < pairs.size(); ++i) {
      const size_t a = pairs[i].a, b = pairs[i].b;
      const bool is_truth = b == SurfacePair::kTruth;
      measure(drawn[a], drawn_on_screen[a], is_truth ? true_row : drawn[b],
              is_truth ? true_on_screen : drawn_on_screen[b], errors);
      const uint32_t covered = tiles[a].covered[y] & (is_truth ? ~0u : tiles[b].covered[y]);
      const uint32_t counted = counting(errors, seen_here & covered, true_row, sight, camera.eye);
      addRow(errors, counted | (seen_here & ~covered), covered, first + glm::uvec2(0, y), sums[i]);
    }
  }
}

void Oracle::Impl::finish(Deviation& d) {
  const double count = static_cast<double>(std::max<uint64_t>(d.samples, 1));
  d.max_px = std::sqrt(d.max_px), d.max_m = std::sqrt(d.max_m);
  d.rms_px = std::sqrt(d.rms_px / count), d.rms_m = std::sqrt(d.rms_m / count);
}

Oracle::Oracle(Truth truth, double near_m)
    : impl_(std::make_unique<Impl>(std::make_shared<Ground>(std::move(truth)), near_m)) {}
Oracle::Oracle(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Oracle::~Oracle() = default;
Oracle::Oracle(Oracle&&) noexcept = default;

Oracle Oracle::twin() {
  impl_->ground->load();
  Oracle other(std::make_unique<Impl>(impl_->ground, impl_->near_m));
  other.setSight(impl_->sight);
  other.setStretch(impl_->stretch);
  return other;
}

void Oracle::setSight(Sight sight) { impl_->sight = std::move(sight); }
void Oracle::setStretch(const Stretch& stretch) { impl_->stretch = stretch; }

void Oracle::showAt(const TruthTime& time) { impl_->showAt(time); }

size_t Oracle::held() const { return impl_->ground->truth.is_read_on_demand ? impl_->held : 0; }

void Oracle::forget() { impl_->forget(); }

std::span<const double> Oracle::sharesShown() const { return impl_->epoch_shares; }

std::span<const Time> Oracle::epochs() const { return impl_->ground->truth.epochs; }

double Oracle::carriedAt(double x, double y) const {
  const Truth& truth = impl_->ground->truth;
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
  const Camera camera(pose, lens, impl.near_m, impl.stretch);
  impl.chooseBlocks(camera);
  if (impl.tiles.size() < surfaces.size()) {
    impl.rasters.resize(surfaces.size());
    impl.tiles.resize(surfaces.size());
    impl.drawn.resize(surfaces.size());
    impl.drawn_on_screen.resize(surfaces.size());
  }
  for (size_t i = 0; i < surfaces.size(); ++i) impl.build(surfaces[i], impl.rasters[i]);
  std::vector<Deviation> result(pairs.size());
  for (size_t k = 0; k < impl.seen.size(); ++k) {
    for (size_t i = 0; i < surfaces.size(); ++i)
      impl.fill(std::span(impl.rasters[i]).first(surfaces[i].size()), k, impl.tiles[i]);
    impl.judgeBlock(k, surfaces.size(), camera, pairs, result);
  }
  for (Deviation& d : result) impl.finish(d);
  return result;
}

}  // namespace foreland::oracle
