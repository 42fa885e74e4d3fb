#include "terrain/pipeline/make_void_fill.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "terrain/pipeline/scene_parts.h"
#include "terrain/store/file/spool_file.h"

namespace foreland::terrain {

namespace {

constexpr uint64_t kSamplesInWindow = 1u << 20;

class GridOfSource final : public VoidGrid {
 public:
  GridOfSource(ElevationSource& source, SpoolFile levels, const std::function<void(std::span<const float>)>& see,
               const Progress& progress)
      : source_(source), info_(source.info()), levels_(std::move(levels)), see_(see), progress_(progress) {}

  // Hashes of all rows. After the first time that rows were read.
  const std::vector<uint64_t>& sources() const { return sources_; }
  void writeTo(VoidFillWriter& writer) { writer_ = &writer; }

  Status readRow(uint32_t y, std::span<float> out) override {
    if (y < first_ || y - first_ >= count_)
      if (Status s = readWindow(y); !s.ok()) return s;
    std::copy_n(window_.begin() + static_cast<std::ptrdiff_t>(size_t{y - first_} * info_.width), info_.width,
                out.begin());
    const uint64_t hash = hashOfRow(out);
    if (y < sources_.size()) return hash == sources_[y] ? Status() : Status(changedWhileRead(info_.title));
    sources_.push_back(hash);
    see_(out);
    progress_.report(kStage, 0.5 * (y + 1) / info_.height);
    return {};
  }
  Status takeRow(uint32_t y, std::span<const float> row, const RunsOfRow& runs) override {
    progress_.report(kStage, 0.5 + 0.5 * (y + 1) / info_.height);
    return writer_->put(y, row, runs);
  }
  Status put(uint64_t at, std::span<const float> values) override {
    if (!progress_.keepGoing()) return stopped();
    return levels_.put(at * sizeof(float), {reinterpret_cast<const uint8_t*>(values.data()), values.size_bytes()});
  }
  Status get(uint64_t at, std::span<float> values) override {
    return levels_.read(at * sizeof(float), {reinterpret_cast<uint8_t*>(values.data()), values.size_bytes()});
  }

 private:
  static constexpr const char* kStage = "filling voids";

  Status readWindow(uint32_t y) {
    if (!progress_.keepGoing()) return stopped();
    first_ = y, count_ = 0;
    const auto most = static_cast<uint32_t>(std::max<uint64_t>(1, kSamplesInWindow / info_.width));
    const uint32_t count = std::min(most, info_.height - y);
    window_.resize(size_t{count} * info_.width);
    if (Status s = source_.readRows(y, count, window_); !s.ok()) return s;
    count_ = count;
    return {};
  }

  ElevationSource& source_;
  const ElevationInfo& info_;
  SpoolFile levels_;
  const std::function<void(std::span<const float>)>& see_;
  const Progress& progress_;
  std::vector<uint64_t> sources_;
  std::vector<float> window_;
  uint32_t first_ = 0, count_ = 0;  // rows of the window
  VoidFillWriter* writer_ = nullptr;
};

std::filesystem::path fillPath(std::filesystem::path prefix, uint64_t id) {
  std::array<char, 17> name{};
  std::snprintf(name.data(), name.size(), "%016llx", static_cast<unsigned long long>(id));
  prefix += std::string(name.data()) + ".voids";
  return prefix;
}

// Empty if there is none that is whole.
std::shared_ptr<const VoidFill> openWhole(const std::filesystem::path& path, const ElevationInfo& info, uint64_t id) {
  auto fill = VoidFill::open(path, info.width, info.height);
  if (!fill || fill->id() != id || !fill->check().ok()) return nullptr;
  return std::make_shared<const VoidFill>(std::move(fill).value());
}

Status write(const std::filesystem::path& path, const ElevationInfo& info, RowFiller& filler, GridOfSource& grid) {
  auto writer = VoidFillWriter::create(path, info.width, grid.sources(), filler.rows());
  if (!writer) return writer.error();
  grid.writeTo(*writer);
  if (Status s = filler.fill(); !s.ok()) return s;
  return writer->finish();
}

}  // namespace

Result<FilledVoids> makeVoidFill(ElevationSource& source, const std::filesystem::path& prefix,
                                 const std::function<void(std::span<const float> row)>& see, const Progress& progress) {
  const ElevationInfo& info = source.info();
  auto levels = SpoolFile::create(fillPath(prefix, 0));
  if (!levels) return levels.error();
  GridOfSource grid(source, std::move(levels).value(), see, progress);
  RowFiller filler(grid, info.width, info.height);
  if (Status s = filler.look(); !s.ok()) return s.error();
  const VoidReport& report = filler.report();
  if (report.all_void) return onlyVoids(info.title);
  if (report.samples == 0) return changedWhileRead(info.title);
  const uint64_t id = VoidFillWriter::idOf(info.width, grid.sources());
  const auto path = fillPath(prefix, id);
  if (auto kept = openWhole(path, info, id)) return FilledVoids{report, std::move(kept)};
  if (Status s = write(path, info, filler, grid); !s.ok()) return s.error();
  auto fill = VoidFill::open(path, info.width, info.height);
  if (!fill) return fill.error();
  return FilledVoids{report, std::make_shared<const VoidFill>(std::move(fill).value())};
}

}  // namespace foreland::terrain
