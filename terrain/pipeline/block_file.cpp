#include "terrain/pipeline/block_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "terrain/store/file/checksum.h"
#include "terrain/store/file/new_file.h"

namespace foreland::terrain {

namespace {

struct BlockHeader {
  std::array<char, 8> magic{'F', 'O', 'R', 'B', 'L', 'O', 'C', 'K'};
  uint32_t version = 1, byte_order = kByteOrderMark;
  uint64_t id = 0;
  uint64_t checksum = 0;  // XXH64 of what follows
  uint64_t bytes = 0;     // that follow
  uint64_t zero[3]{};
};
static_assert(sizeof(BlockHeader) == 64);

constexpr uint32_t kCoarse = 1u << Blocks::kFineLog2;

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

Status writeBlock(const std::filesystem::path& folder, const BlockPlan& plan, const ElevationInfo& info,
                  const Blocks& blocks, const proto::GeographicTables& tables, uint32_t column, uint32_t row,
                  uint64_t id, const HeightWindow& heights) {
  const ErrorWindow own = blocks.own(column, row), halo = blocks.withHalo(column, row);
  std::vector<int32_t> quanta(size_t{widthOf(halo)} * heightOf(halo));
  auto out = quanta.begin();
  for (uint32_t y = halo.low_y; y <= halo.high_y; ++y)
    for (uint32_t x = halo.low_x; x <= halo.high_x; ++x) {
      const float metres = heights.at(info, x, y);
      const auto value = quantised(metres, plan.frame.height_quantum_m);
      if (!value)
        return Error{ErrorCode::kLimit, info.title + ": a height of " + std::to_string(metres) +
                                            " m, which the plan has not; make the plan again"};
      *out++ = *value;
    }
  const BlockBounds bounds = boundBlock(blocks, plan.frame, tables, column, row, quanta);
  const BlockLayout layout = layoutOf(blocks, column, row);
  auto file = NewFile::create(blockPath(folder, id), sizeof(BlockHeader) + layout.bytes);
  if (!file) return file.error();
  uint8_t* payload = file->data() + sizeof(BlockHeader);
  auto* points = reinterpret_cast<BlockPoint*>(payload);
  auto* coarse = reinterpret_cast<int32_t*>(payload + layout.coarse_at);
  const auto heightAt = [&](uint32_t x, uint32_t y) {
    return quanta[size_t{y - halo.low_y} * widthOf(halo) + (x - halo.low_x)];
  };
  size_t i = 0;
  for (uint32_t y = own.low_y; y <= own.high_y; ++y)
    for (uint32_t x = own.low_x; x <= own.high_x; ++x, ++i)
      points[i] = BlockPoint::of(heightAt(x, y), bounds.errors[i]);
  for (uint32_t y = own.low_y; y <= own.high_y; y += kCoarse)
    for (uint32_t x = own.low_x; x <= own.high_x; x += kCoarse) *coarse++ = heightAt(x, y);
  for (size_t l = 0; l < bounds.reach.size(); ++l)
    std::memcpy(payload + layout.reach_at[l], bounds.reach[l].data(), bounds.reach[l].size() * sizeof(PageReach));
  BlockHeader header;
  header.id = id;
  header.bytes = layout.bytes;
  header.checksum = xxh64({payload, layout.bytes});
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
  if (header.bytes != layout.bytes || block.file_.bytes() != sizeof(header) + layout.bytes) return block.damaged();
  block.own_ = blocks.own(column, row);
  block.checksum_ = header.checksum;
  block.bytes_ = layout.bytes;
  block.coarse_at_ = layout.coarse_at;
  block.coarsest_ = blocks.coarsestFineLevel();
  block.reach_at_ = layout.reach_at;
  block.reach_count_ = layout.reach_count;
  return block;
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
