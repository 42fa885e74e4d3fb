#include "terrain/store/coded/write_coded.h"

#include <algorithm>

#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

// Models start as some groups want it, evenly spread, and coarse levels' among them.
ModelStart train(const CodedTerrain& terrain, GroupReader& records, uint64_t groups) {
  constexpr uint64_t kMost = 1024;
  ModelTrainer trainer;
  const uint64_t each = (groups + kMost - 1) / kMost;
  for (uint64_t group = 0; group < groups; group += each) trainer.add(terrain, records, group);
  return trainer.start();
}

}  // namespace

Result<CodedPagesWriter> CodedPagesWriter::create(const CodedTerrain& terrain, const GroupReader::Read& read,
                                                  const std::filesystem::path& target, unsigned threads) {
  constexpr uint64_t kAtATime = 512;
  const uint64_t groups = groupCount(terrain.directory.pageCount());
  auto spool = SpoolFile::create(target);
  if (!spool) return spool.error();
  CodedPagesWriter writer(std::move(*spool));
  std::vector<GroupReader> records;  // by worker
  for (unsigned i = 0; i < threadCount(threads); ++i)
    records.emplace_back(terrain.directory.pageCount() * proto::kPageSlots, read);
  const ModelStart start = train(terrain, records.front(), groups);
  if (Status s = writer.append(start.encode()); !s.ok()) return s.error();
  std::vector<Bytes> coded(kAtATime);
  for (uint64_t begin = 0; begin < groups; begin += kAtATime) {
    const uint64_t count = std::min(kAtATime, groups - begin);
    parallelFor(
        count, threads,
        [&](uint64_t i, unsigned worker) {
          const auto model = std::make_unique<PageModel>();
          start.apply(*model);
          coded[i].clear();
          encodeGroup(terrain, records[worker], begin + i, *model, coded[i]);
        },
        [](uint64_t) { return true; });
    for (const GroupReader& reader : records)
      if (!reader.status().ok()) return reader.status().error();
    for (uint64_t i = 0; i < count; ++i) {
      if (coded[i].empty()) coded[i].push_back(0);  // no bytes are a damaged group
      if (Status s = writer.append(coded[i]); !s.ok()) return s.error();
    }
  }
  return writer;
}

Status CodedPagesWriter::append(ByteSpan bytes) {
  const auto offset = spool_.append(bytes);
  if (!offset) return offset.error();
  ends_.push_back(*offset + bytes.size());
  return {};
}

Status CodedPagesWriter::write(const std::function<Status(uint64_t offset, ByteSpan what)>& put) const {
  const uint64_t table = CodedSection::tableBytes(ends_.size() - 1);
  if (Status s = put(0, {reinterpret_cast<const uint8_t*>(ends_.data()), table}); !s.ok()) return s;
  constexpr uint64_t kPiece = 1u << 22;
  Bytes piece;
  for (uint64_t at = 0; at < spool_.bytes(); at += kPiece) {
    piece.resize(std::min(kPiece, spool_.bytes() - at));
    if (Status s = spool_.read(at, piece); !s.ok()) return s;
    if (Status s = put(table + at, piece); !s.ok()) return s;
  }
  return {};
}

}  // namespace foreland::terrain
