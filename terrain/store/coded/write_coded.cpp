#include "terrain/store/coded/write_coded.h"

#include <algorithm>
#include <cstring>

#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

// Models start as some groups want it, evenly spread, and coarse levels' among them.
ModelStart train(const CodedTerrain& terrain, uint64_t groups) {
  constexpr uint64_t kMost = 1024;
  ModelTrainer trainer;
  const uint64_t each = (groups + kMost - 1) / kMost;
  for (uint64_t group = 0; group < groups; group += each) trainer.add(terrain, group);
  return trainer.start();
}

}  // namespace

Result<CodedPagesWriter> CodedPagesWriter::create(const CodedTerrain& terrain, const std::filesystem::path& target,
                                                  unsigned threads) {
  constexpr uint64_t kAtATime = 512;
  const uint64_t groups = groupCount(terrain.directory.pageCount());
  auto spool = SpoolFile::create(target);
  if (!spool) return spool.error();
  CodedPagesWriter writer(std::move(*spool));
  const ModelStart start = train(terrain, groups);
  if (Status s = writer.append(start.encode()); !s.ok()) return s.error();
  std::vector<Bytes> coded(kAtATime);
  for (uint64_t begin = 0; begin < groups; begin += kAtATime) {
    const uint64_t count = std::min(kAtATime, groups - begin);
    parallelFor(
        count, threads,
        [&](uint64_t i, unsigned) {
          const auto model = std::make_unique<PageModel>();
          start.apply(*model);
          coded[i].clear();
          encodeGroup(terrain, begin + i, *model, coded[i]);
        },
        [](uint64_t) { return true; });
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

Status CodedPagesWriter::write(std::span<uint8_t> out) const {
  CHECK_EQ(out.size(), bytes());
  std::memcpy(out.data(), ends_.data(), ends_.size() * sizeof(uint64_t));
  constexpr uint64_t kPiece = 1u << 22;
  const std::span<uint8_t> coded = out.subspan(CodedSection::tableBytes(ends_.size() - 1));
  for (uint64_t at = 0; at < coded.size(); at += kPiece)
    if (Status s = spool_.read(at, coded.subspan(at, std::min(kPiece, coded.size() - at))); !s.ok()) return s;
  return {};
}

}  // namespace foreland::terrain
