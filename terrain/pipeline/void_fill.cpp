#include "terrain/pipeline/void_fill.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/check.h"
#include "terrain/store/file/checksum.h"
#include "terrain/store/format.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kFillVersion = 1;  // moves when the same voids would be filled with other heights

struct FillHeader {
  std::array<char, 8> magic{'F', 'O', 'R', 'V', 'O', 'I', 'D', 'S'};
  uint32_t version = kFillVersion, byte_order = kByteOrderMark;
  uint32_t width = 0, height = 0;
  uint64_t bytes = 0;     // of the file
  uint64_t checksum = 0;  // XXH64 of the rows' places, which follow
  uint64_t zero[3]{};
};
static_assert(sizeof(FillHeader) == 64 && sizeof(FilledRow) == 24);

template <class T>
std::span<uint8_t> writableBytes(std::span<T> values) {
  return {reinterpret_cast<uint8_t*>(values.data()), values.size_bytes()};
}
template <class T>
ByteSpan bytesOfAll(std::span<const T> values) {
  return {reinterpret_cast<const uint8_t*>(values.data()), values.size_bytes()};
}

// A row is the number of its runs, their first samples and lengths, and then all of their heights.
constexpr uint64_t wordsFor(uint64_t runs, uint64_t samples) { return 1 + 2 * runs + samples; }

// The heights of a row's runs begin at this word; 0 if these are no runs of such a row.
size_t heightsBegin(std::span<const uint32_t> words, size_t width) {
  const uint64_t runs = words[0];
  if (runs > words.size() / 2) return 0;
  const size_t begin = 1 + 2 * runs;
  uint64_t samples = 0, free = 0;
  for (size_t i = 1; i < begin; i += 2) {
    if (begin > words.size() || words[i] < free || words[i + 1] > width - std::min<uint64_t>(words[i], width)) return 0;
    free = uint64_t{words[i]} + words[i + 1];
    samples += words[i + 1];
  }
  return begin + samples == words.size() ? begin : 0;
}

}  // namespace

uint64_t hashOfRow(std::span<float> row) {
  for (float& h : row)
    if (!std::isfinite(h)) h = kVoid;
  return xxh64(bytesOfAll(std::span<const float>(row)));
}

uint64_t VoidFillWriter::idOf(uint32_t width, std::span<const uint64_t> sources) {
  return xxh64(bytesOfAll(sources), uint64_t{kFillVersion} << 32 | width);
}

Result<VoidFillWriter> VoidFillWriter::create(const std::filesystem::path& path, uint32_t width,
                                              std::span<const uint64_t> sources,
                                              std::span<const RowFiller::RowVoids> rows) {
  std::vector<FilledRow> places(rows.size());
  uint64_t at = sizeof(FillHeader) + places.size() * sizeof(FilledRow);
  for (size_t y = 0; y < rows.size(); ++y) {
    places[y] = {.at = at, .source = sources[y]};
    if (rows[y].runs > 0) at += wordsFor(rows[y].runs, rows[y].samples) * sizeof(uint32_t);
  }
  auto file = NewFile::create(path, at, FileMapping::kNone);
  if (!file) return file.error();
  VoidFillWriter writer(std::move(file).value());
  writer.width_ = width;
  writer.rows_ = std::move(places);
  return writer;
}

Status VoidFillWriter::put(uint32_t y, std::span<const float> row, const RunsOfRow& runs) {
  std::vector<uint32_t> words{static_cast<uint32_t>(runs.size())};
  for (const auto& [begin, end] : runs) words.insert(words.end(), {begin, end - begin});
  for (const auto& [begin, end] : runs) {
    const size_t at = words.size();
    words.resize(at + (end - begin));
    std::memcpy(words.data() + at, row.data() + begin, (end - begin) * sizeof(float));
  }
  const ByteSpan bytes = bytesOfAll(std::span<const uint32_t>(words));
  CHECK_EQ(rows_[y].at + bytes.size(), y + 1 < rows_.size() ? rows_[y + 1].at : file_.bytes());
  rows_[y].checksum = xxh64(bytes);
  return file_.put(rows_[y].at, bytes);
}

Status VoidFillWriter::finish() {
  const ByteSpan places = bytesOfAll(std::span<const FilledRow>(rows_));
  FillHeader header;
  header.width = width_, header.height = static_cast<uint32_t>(rows_.size());
  header.bytes = file_.bytes();
  header.checksum = xxh64(places);
  if (Status s = file_.put(0, {reinterpret_cast<const uint8_t*>(&header), sizeof(header)}); !s.ok()) return s;
  if (Status s = file_.put(sizeof(header), places); !s.ok()) return s;
  return file_.finish();
}

Result<VoidFill> VoidFill::open(const std::filesystem::path& path, uint32_t width, uint32_t height) {
  VoidFill fill;
  fill.path_ = path;
  fill.file_ = InputFile(path);
  if (!fill.file_.isOpen())
    return Error{ErrorCode::kIo, path.string() + ": " + std::strerror(errno) +
                                     "; it has what voids are filled with: make the plan again with foreland plan"};
  FillHeader header;
  const FillHeader wanted;
  if (!fill.read(0, {reinterpret_cast<uint8_t*>(&header), sizeof(header)}).ok() || header.magic != wanted.magic ||
      header.version != wanted.version || header.byte_order != wanted.byte_order || header.width != width ||
      header.height != height || fill.file_.bytes() != header.bytes)
    return fill.damaged();
  fill.bytes_ = header.bytes;
  fill.rows_.resize(height);
  if (!fill.read(sizeof(header), writableBytes(std::span(fill.rows_))).ok() ||
      xxh64(bytesOfAll(std::span<const FilledRow>(fill.rows_))) != header.checksum)
    return fill.damaged();
  std::vector<uint64_t> sources;
  uint64_t before = sizeof(header);
  for (const FilledRow& row : fill.rows_) {
    if (row.at < before || row.at > fill.bytes_ || row.at % sizeof(uint32_t) != 0) return fill.damaged();
    before = row.at;
    sources.push_back(row.source);
  }
  fill.id_ = VoidFillWriter::idOf(width, sources);
  return fill;
}

Error VoidFill::damaged() const {
  return {ErrorCode::kMalformed, path_.string() +
                                     ": damaged, or not what these voids are filled with; remove it, and make the plan "
                                     "again with foreland plan, or build again"};
}

Status VoidFill::read(uint64_t offset, std::span<uint8_t> out) const {
  return file_.read(offset, out) ? Status() : Status(damaged());
}

Result<std::vector<uint32_t>> VoidFill::wordsOf(uint32_t y) const {
  const uint64_t end = y + 1 < rows_.size() ? rows_[y + 1].at : bytes_;
  std::vector<uint32_t> words((end - rows_[y].at) / sizeof(uint32_t));
  if (words.empty()) return words;
  if (Status s = read(rows_[y].at, writableBytes(std::span(words))); !s.ok()) return s.error();
  if (xxh64(bytesOfAll(std::span<const uint32_t>(words))) != rows_[y].checksum) return damaged();
  return words;
}

Status VoidFill::check() const {
  for (uint32_t y = 0; y < rows_.size(); ++y)
    if (const auto words = wordsOf(y); !words) return words.error();
  return {};
}

Status VoidFill::fillRow(uint32_t y, std::span<float> row) const {
  const auto words = wordsOf(y);
  if (!words) return words.error();
  if (words->empty()) return {};
  size_t at = heightsBegin(*words, row.size());
  if (at == 0) return damaged();
  for (size_t i = 1; i < 1 + 2 * size_t{words->front()}; i += 2) {
    const uint32_t begin = (*words)[i], count = (*words)[i + 1];
    std::memcpy(row.data() + begin, words->data() + at, count * sizeof(float));
    at += count;
  }
  return {};
}

Status FilledSource::readRows(uint32_t first, uint32_t count, std::span<float> out) {
  if (Status s = source_.readRows(first, count, out); !s.ok()) return s;
  const size_t width = info().width;
  for (uint32_t i = 0; i < count; ++i) {
    const std::span<float> row = out.subspan(i * width, width);
    if (!fill_.isOf(first + i, row))
      return Error{ErrorCode::kInvalidArgument, info().title + ": has changed since its voids were filled (" +
                                                    fill_.path().string() +
                                                    "); make the plan again with foreland plan, or build again"};
    if (Status s = fill_.fillRow(first + i, row); !s.ok()) return s;
  }
  return {};
}

}  // namespace foreland::terrain
