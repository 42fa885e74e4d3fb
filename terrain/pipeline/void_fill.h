// What the voids of a source are filled with, as a file: runs of filled heights, by rows. It appears whole or not at
// all, knows which heights it was made of, and is laid over these alone. One thread at a time.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "terrain/dem/voids/row_filler.h"
#include "terrain/elevation_source.h"
#include "terrain/store/file/input_file.h"
#include "terrain/store/file/new_file.h"

namespace foreland::terrain {

// A row's place in the file.
struct FilledRow {
  uint64_t at = 0;        // in bytes; it ends where the next one begins
  uint64_t checksum = 0;  // XXH64 of what is there
  uint64_t source = 0;    // of the row that was filled, by hashOfRow()
};

// Makes all voids of a row kVoid, and returns its XXH64.
uint64_t hashOfRow(std::span<float> row);

class VoidFillWriter {
 public:
  // `sources` are the hashes of all rows; their hash is the file's id, which its name is to say.
  static uint64_t idOf(uint32_t width, std::span<const uint64_t> sources);
  static Result<VoidFillWriter> create(const std::filesystem::path& path, uint32_t width,
                                       std::span<const uint64_t> sources, std::span<const RowFiller::RowVoids> rows);
  // Of each row that has voids.
  Status put(uint32_t y, std::span<const float> row, const RunsOfRow& runs);
  // To be called once, when all rows are there.
  Status finish();

 private:
  explicit VoidFillWriter(NewFile file) : file_(std::move(file)) {}
  NewFile file_;
  uint32_t width_ = 0;
  std::vector<FilledRow> rows_;
};

class VoidFill {
 public:
  // An Error says that the file is missing or damaged, and what to do.
  static Result<VoidFill> open(const std::filesystem::path& path, uint32_t width, uint32_t height);

  uint64_t id() const { return id_; }
  const std::filesystem::path& path() const { return path_; }
  // Reads all of the file. An Error: it is damaged.
  Status check() const;
  // Whether row y was filled from these heights. Makes all voids kVoid.
  bool isOf(uint32_t y, std::span<float> row) const { return hashOfRow(row) == rows_[y].source; }
  // Fills the voids of row y, of which the fill must be. An Error: the file is damaged.
  Status fillRow(uint32_t y, std::span<float> row) const;

 private:
  VoidFill() = default;
  Error damaged() const;
  Status read(uint64_t offset, std::span<uint8_t> out) const;
  Result<std::vector<uint32_t>> wordsOf(uint32_t y) const;

  std::filesystem::path path_;
  InputFile file_;
  uint64_t id_ = 0, bytes_ = 0;
  std::vector<FilledRow> rows_;
};

// A source whose voids are filled. Both have to outlive it.
class FilledSource final : public ElevationSource {
 public:
  FilledSource(ElevationSource& source, const VoidFill& fill) : source_(source), fill_(fill) {}
  const ElevationInfo& info() const override { return source_.info(); }
  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override;
  const SparseHeights* sparse() const override { return source_.sparse(); }
  std::vector<std::string> warnings() const override { return source_.warnings(); }

 private:
  ElevationSource& source_;
  const VoidFill& fill_;
};

}  // namespace foreland::terrain
