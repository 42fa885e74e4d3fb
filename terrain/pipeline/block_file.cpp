#include "terrain/pipeline/block_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "terrain/epochs/epoch_walk.h"
#include "terrain/pipeline/scene_parts.h"
#include "terrain/store/file/checksum.h"
#include "terrain/store/file/new_file.h"

namespace foreland::terrain {

namespace {

struct BlockHeader {
  std::array<char, 8> magic{'F', 'O', 'R', 'B', 'L', 'O', 'C', 'K'};
  uint32_t version = 1, byte_order = kByteOrderMark;
  uint64_t id = 0;
  uint64_t checksum = 0;  // XXH64 of what follows, without the differences of layers
  uint64_t bytes = 0;     // that follow
  uint64_t layers = 0;    // BlockLayer, behind the pages' reach
  uint64_t zero[2]{};
};
static_assert(sizeof(BlockHeader) == 64);

constexpr uint32_t kCoarse = 1u << Blocks::kFineLog2;

ByteSpan bytesOfDifferences(const std::vector<int32_t>& quanta) {
  return {reinterpret_cast<const uint8_t*>(quanta.data()), quanta.size() * sizeof(int32_t)};
}

std::span<uint8_t> writableBytesOfLayers(std::vector<BlockLayer>& layers) {
  return {reinterpret_cast<uint8_t*>(layers.data()), layers.size() * sizeof(BlockLayer)};
}

constexpr uint64_t kMostLayers = proto::Epochs::kMax + 1;

// Where the parts of a block's file begin, after its header.
struct BlockLayout {
  uint64_t coarse_at = 0, bytes = 0;
  std::vector<uint64_t> reach_at, reach_count;
};

BlockLayout layoutOf(const Blocks& blocks, uint32_t column, uint32_t row) {
  const ErrorWindow own = blocks.own(column, row);
  BlockLayout layout;
  layout.coarse_at = sizeof(BlockPoint) * uint64_t{widthOf(own)} * heightOf(own);
  uint64_t at = layout.coarse_at +
                sizeof(int32_t) * uint64_t{(widthOf(own) - 1) / kCoarse + 1} * ((heightOf(own) - 1) / kCoarse + 1);
  at = (at + 7) / 8 * 8;
  for (int level = blocks.coarsestFineLevel(); level <= blocks.grid.maxLevel(); ++level) {
    layout.reach_at.push_back(at);
    layout.reach_count.push_back(blocks.pages(level, column, row).count());
    at += sizeof(PageReach) * layout.reach_count.back();
  }
  layout.bytes = at;
  return layout;
}

}  // namespace

std::filesystem::path blockPath(const std::filesystem::path& folder, uint64_t id) {
  std::array<char, 17> name{};
  std::snprintf(name.data(), name.size(), "%016llx", static_cast<unsigned long long>(id));
  return folder / (std::string(name.data()) + ".block");
}

namespace {

// A layer, and the differences that the file has of it.
struct MadeLayer {
  BlockLayer layer;
  std::vector<int32_t> quanta;
};

// A block's ground at all dates, and what follows of it.
class BlockMaker {
 public:
  BlockMaker(const BlockPlan& plan, const ElevationInfo& info, const Blocks& blocks,
             const proto::GeographicTables& tables, uint32_t column, uint32_t row, const HeightWindow& heights)
      : plan_(plan),
        own_(blocks.own(column, row)),
        halo_(blocks.withHalo(column, row)),
        samples_(samplesIn(halo_, info)),
        own_samples_(
            proto::LatticeWindow::common({own_.low_x, own_.low_y, widthOf(own_), heightOf(own_)}, wholeOf(info))),
        heights_(heights),
        title_(info.title),
        bounder_(blocks, plan.frame, tables, column, row) {}

  Status make() {
    if (Status s = quantise(); !s.ok()) return s;
    const std::vector<int32_t> ground = inHalo(first_);
    const bool moves = std::ranges::any_of(heights_.epochs, [&](const EpochSamples& epoch) {
      return !proto::LatticeWindow::common(epoch.window, samples_).isEmpty();
    });
    if (!moves) {
      bounds_ = bounder_.finish(ground, {});
      return {};
    }
    return makeLayers(ground);
  }

  const BlockBounds& bounds() const { return bounds_; }
  std::span<MadeLayer> layers() { return layers_; }
  int32_t heightAt(uint32_t x, uint32_t y) const { return at(first_, x, y); }

 private:
  // Of any lattice point whose nearest sample is in the window with its halo.
  int32_t at(std::span<const int32_t> quanta, uint32_t x, uint32_t y) const {
    return quanta[size_t{std::min(y - samples_.y, samples_.height - 1)} * samples_.width +
                  std::min(x - samples_.x, samples_.width - 1)];
  }
  std::vector<int32_t> inHalo(std::span<const int32_t> quanta) const {
    std::vector<int32_t> all(size_t{widthOf(halo_)} * heightOf(halo_));
    auto out = all.begin();
    for (uint32_t y = halo_.low_y; y <= halo_.high_y; ++y)
      for (uint32_t x = halo_.low_x; x <= halo_.high_x; ++x) *out++ = at(quanta, x, y);
    return all;
  }

  Status quantise() {
    for (uint32_t y = samples_.y; y < samples_.y + samples_.height; ++y)
      for (uint32_t x = samples_.x; x < samples_.x + samples_.width; ++x) {
        const float metres = heights_.metres[size_t{y - heights_.y} * heights_.width + (x - heights_.x)];
        const auto value = quantised(metres, plan_.frame.height_quantum_m);
        if (!value)
          return Error{ErrorCode::kLimit, title_ + ": a height of " + std::to_string(metres) +
                                              " m, which the plan has not; make the plan again"};
        first_.push_back(*value);
      }
    return {};
  }

  Status makeLayers(std::span<const int32_t> ground) {
    const auto dates = datesOf(plan_.epochs, plan_.epoch_blend, plan_.shape);
    if (!dates) return dates.error();
    EpochWalk walk(samples_, plan_.frame, first_, *dates);
    for (size_t i = 1; i < heights_.epochs.size(); ++i) {
      const Status moved = walk.next(heights_.epochs[i], [&](const GroundAtTime& then) -> Status {
        bounder_.addErrors(inHalo(then.quanta), then.changed.y, lastRowOf(then.changed));
        return {};
      });
      if (!moved.ok()) return moved;
      if (!proto::LatticeWindow::common(walk.change().window, own_samples_).isEmpty())
        addLayer(heights_.epochs[i].time.us, walk.ground());
    }
    if (!layers_.empty()) addLayer(BlockLayer::kLowest, walk.lowest()), addLayer(BlockLayer::kHighest, walk.highest());
    const std::vector<int32_t> lowest = inHalo(walk.lowest()), highest = inHalo(walk.highest());
    const std::array<HaloHeights, 2> extremes{lowest, highest};
    bounds_ = bounder_.finish(ground, extremes);
    return {};
  }

  // Beyond the data rows repeat the last one.
  uint32_t lastRowOf(const proto::LatticeWindow& changed) const { return changed.y + changed.height - 1; }

  void addLayer(int64_t time_us, std::span<const int32_t> ground) {
    MadeLayer made{{.time_us = time_us}, {}};
    proto::LatticeWindow window;
    const auto differenceAt = [&](uint32_t x, uint32_t y) { return at(ground, x, y) - at(first_, x, y); };
    forEachIn(own_samples_, [&](uint32_t x, uint32_t y) {
      if (differenceAt(x, y) != 0) window = proto::LatticeWindow::hull(window, {x, y, 1, 1});
    });
    forEachIn(window, [&](uint32_t x, uint32_t y) { made.quanta.push_back(differenceAt(x, y)); });
    made.layer.x = window.x, made.layer.y = window.y, made.layer.width = window.width,
    made.layer.height = window.height;
    layers_.push_back(std::move(made));
  }
  template <class Visit>
  static void forEachIn(const proto::LatticeWindow& w, const Visit& visit) {
    for (uint32_t y = w.y; y < w.y + w.height; ++y)
      for (uint32_t x = w.x; x < w.x + w.width; ++x) visit(x, y);
  }

  const BlockPlan& plan_;
  ErrorWindow own_, halo_;
  proto::LatticeWindow samples_, own_samples_;  // of the halo; of the block, none beyond the data
  const HeightWindow& heights_;
  const std::string& title_;
  BlockBounder bounder_;
  std::vector<int32_t> first_;  // of samples_, at the first epoch
  BlockBounds bounds_;
  std::vector<MadeLayer> layers_;
};

}  // namespace

Status writeBlock(const std::filesystem::path& folder, const BlockPlan& plan, const ElevationInfo& info,
                  const Blocks& blocks, const proto::GeographicTables& tables, uint32_t column, uint32_t row,
                  uint64_t id, const HeightWindow& heights) {
  BlockMaker made(plan, info, blocks, tables, column, row, heights);
  if (Status s = made.make(); !s.ok()) return s;
  const ErrorWindow own = blocks.own(column, row);
  const BlockBounds& bounds = made.bounds();
  const BlockLayout layout = layoutOf(blocks, column, row);
  const uint64_t table_bytes = made.layers().size() * sizeof(BlockLayer);
  uint64_t bytes = layout.bytes + table_bytes;
  for (MadeLayer& layer : made.layers()) {
    layer.layer.at = bytes;
    layer.layer.checksum = xxh64(bytesOfDifferences(layer.quanta));
    bytes += layer.layer.bytes();
  }
  auto file = NewFile::create(blockPath(folder, id), sizeof(BlockHeader) + bytes);
  if (!file) return file.error();
  uint8_t* payload = file->data() + sizeof(BlockHeader);
  auto* points = reinterpret_cast<BlockPoint*>(payload);
  auto* coarse = reinterpret_cast<int32_t*>(payload + layout.coarse_at);
  size_t i = 0;
  for (uint32_t y = own.low_y; y <= own.high_y; ++y)
    for (uint32_t x = own.low_x; x <= own.high_x; ++x, ++i)
      points[i] = BlockPoint::of(made.heightAt(x, y), bounds.errors[i]);
  for (uint32_t y = own.low_y; y <= own.high_y; y += kCoarse)
    for (uint32_t x = own.low_x; x <= own.high_x; x += kCoarse) *coarse++ = made.heightAt(x, y);
  for (size_t l = 0; l < bounds.reach.size(); ++l)
    std::memcpy(payload + layout.reach_at[l], bounds.reach[l].data(), bounds.reach[l].size() * sizeof(PageReach));
  uint8_t* entry = payload + layout.bytes;
  for (const MadeLayer& layer : made.layers()) {
    std::memcpy(entry, &layer.layer, sizeof(BlockLayer));
    entry += sizeof(BlockLayer);
    if (!layer.quanta.empty()) std::memcpy(payload + layer.layer.at, layer.quanta.data(), layer.layer.bytes());
  }
  BlockHeader header;
  header.id = id;
  header.bytes = bytes;
  header.layers = made.layers().size();
  header.checksum = xxh64({payload, layout.bytes + table_bytes});
  std::memcpy(file->data(), &header, sizeof(header));
  return file->finish();
}

Result<BlockFile> BlockFile::open(const std::filesystem::path& folder, const Blocks& blocks, uint32_t column,
                                  uint32_t row, uint64_t id) {
  BlockFile block;
  block.path_ = blockPath(folder, id);
  const std::string name = "block " + std::to_string(uint64_t{row} * blocks.columns() + column);
  block.file_ = InputFile(block.path_);
  if (!block.file_.isOpen())
    return Error{ErrorCode::kIo, block.path_.string() + ": " + std::strerror(errno) + "; " + name +
                                     " of the plan is missing: make it with foreland block"};
  const BlockLayout layout = layoutOf(blocks, column, row);
  BlockHeader header;
  const BlockHeader wanted;
  if (!block.read(0, {reinterpret_cast<uint8_t*>(&header), sizeof(header)}).ok() || header.magic != wanted.magic ||
      header.version != wanted.version || header.byte_order != wanted.byte_order)
    return block.damaged();
  if (header.id != id)
    return Error{ErrorCode::kMalformed, block.path_.string() + ": another block than its name says, not " + name +
                                            " of this plan; remove it, and make it again with foreland block"};
  if (header.layers > kMostLayers || block.file_.bytes() != sizeof(header) + header.bytes) return block.damaged();
  block.own_ = blocks.own(column, row);
  block.checksum_ = header.checksum;
  block.bytes_ = layout.bytes + header.layers * sizeof(BlockLayer);
  block.layers_.resize(header.layers);
  if (!block.readLayers(layout.bytes, header.bytes).ok()) return block.damaged();
  block.coarse_at_ = layout.coarse_at;
  block.coarsest_ = blocks.coarsestFineLevel();
  block.reach_at_ = layout.reach_at;
  block.reach_count_ = layout.reach_count;
  return block;
}

// The table, which is at `at`; layers fill what follows it of all bytes.
Status BlockFile::readLayers(uint64_t at, uint64_t bytes) {
  if (Status s = read(sizeof(BlockHeader) + at, writableBytesOfLayers(layers_)); !s.ok()) return s;
  uint64_t next = at + layers_.size() * sizeof(BlockLayer);
  int64_t before = INT64_MIN;
  for (const BlockLayer& layer : layers_) {
    const bool is_inside = layer.window().isEmpty() ||
                           (layer.x >= own_.low_x && uint64_t{layer.x} + layer.width <= uint64_t{own_.high_x} + 1 &&
                            layer.y >= own_.low_y && uint64_t{layer.y} + layer.height <= uint64_t{own_.high_y} + 1);
    if (!is_inside || layer.at != next || layer.time_us <= before) return damaged();
    next += layer.bytes();
    before = layer.time_us;
  }
  const bool is_complete = layers_.empty() || (extreme(BlockLayer::kLowest) && extreme(BlockLayer::kHighest));
  return next == bytes && is_complete ? Status() : Status(damaged());
}

const BlockLayer* BlockFile::layerAt(Time date) const {
  const BlockLayer* found = nullptr;
  for (const BlockLayer& layer : layers_)
    if (layer.time_us <= date.us) found = &layer;
  return found;
}

const BlockLayer* BlockFile::extreme(int64_t which) const {
  for (const BlockLayer& layer : layers_)
    if (layer.time_us == which) return &layer;
  return nullptr;
}

Status BlockFile::row(const BlockLayer* layer, uint32_t y, uint32_t first, std::span<int32_t> out) const {
  std::ranges::fill(out, 0);
  if (!layer) return {};
  const auto common = proto::LatticeWindow::common(layer->window(), {first, y, static_cast<uint32_t>(out.size()), 1});
  if (common.isEmpty()) return {};
  const uint64_t at = layer->at + sizeof(int32_t) * (uint64_t{y - layer->y} * layer->width + (common.x - layer->x));
  return read(sizeof(BlockHeader) + at,
              {reinterpret_cast<uint8_t*>(out.data() + (common.x - first)), common.width * sizeof(int32_t)});
}

Error BlockFile::damaged() const {
  return {ErrorCode::kMalformed,
          path_.string() + ": damaged, or no block; remove it, and make it again with foreland block"};
}

Status BlockFile::read(uint64_t offset, std::span<uint8_t> out) const {
  return file_.read(offset, out) ? Status() : Status(damaged());
}

Result<std::vector<BlockPoint>> BlockFile::points() const {
  Bytes all(bytes_);
  if (Status s = read(sizeof(BlockHeader), all); !s.ok()) return s.error();
  if (xxh64(all) != checksum_) return damaged();
  for (const BlockLayer& layer : layers_) {
    Bytes differences(layer.bytes());
    if (Status s = read(sizeof(BlockHeader) + layer.at, differences); !s.ok()) return s.error();
    if (xxh64(differences) != layer.checksum) return damaged();
  }
  std::vector<BlockPoint> points(size_t{widthOf(own_)} * heightOf(own_));
  std::memcpy(points.data(), all.data(), points.size() * sizeof(BlockPoint));
  return points;
}

Status BlockFile::row(uint32_t y, uint32_t first, std::span<BlockPoint> out) const {
  const uint64_t at = uint64_t{y - own_.low_y} * widthOf(own_) + (first - own_.low_x);
  return read(sizeof(BlockHeader) + at * sizeof(BlockPoint),
              {reinterpret_cast<uint8_t*>(out.data()), out.size_bytes()});
}

Result<std::vector<int32_t>> BlockFile::coarseHeights() const {
  std::vector<int32_t> heights(size_t{(widthOf(own_) - 1) / kCoarse + 1} * ((heightOf(own_) - 1) / kCoarse + 1));
  const Status s = read(sizeof(BlockHeader) + coarse_at_,
                        {reinterpret_cast<uint8_t*>(heights.data()), heights.size() * sizeof(int32_t)});
  if (!s.ok()) return s.error();
  return heights;
}

Result<std::vector<PageReach>> BlockFile::reach(int level) const {
  const auto l = static_cast<size_t>(level - coarsest_);
  std::vector<PageReach> reach(reach_count_[l]);
  const Status s = read(sizeof(BlockHeader) + reach_at_[l],
                        {reinterpret_cast<uint8_t*>(reach.data()), reach.size() * sizeof(PageReach)});
  if (!s.ok()) return s.error();
  return reach;
}

}  // namespace foreland::terrain
