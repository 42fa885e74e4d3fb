#include "terrain/store/scene_writer.h"

#include <algorithm>
#include <utility>

#include "base/check.h"
#include "terrain/store/coded/write_coded.h"
#include "terrain/store/file/mapped_file.h"
#include "terrain/store/file/seal.h"

namespace foreland::terrain {

namespace {

template <class T>
ByteSpan bytesOf(std::span<const T> values) {
  return {reinterpret_cast<const uint8_t*>(values.data()), values.size_bytes()};
}

template <class T>
std::span<uint8_t> writableBytesOf(std::span<T> values) {
  return {reinterpret_cast<uint8_t*>(values.data()), values.size_bytes()};
}

// The oldest that holds it, so that a scene has the bytes that it always had.
uint32_t versionFor(const SceneWriter::About& about, bool is_stated) {
  if (about.page_coding == PageCoding::kCoded) return kFormatVersion;
  if (about.shape.sparse_levels > 0) return FileHeader::kPlainVersion;
  if (is_stated) return FileHeader::kWholeVersion;
  return about.epoch_blend == proto::EpochBlend::kLinear ? FileHeader::kLinearVersion : FileHeader::kUnstatedVersion;
}

}  // namespace

Result<SceneWriter> SceneWriter::create(const std::filesystem::path& target, const About& about) {
  auto grid = proto::GridTopology::create(about.shape);
  if (!grid.ok()) return grid.error();
  if (Status frame = about.frame.validate(grid->maxX(), grid->maxY()); !frame.ok()) return frame.error();
  auto directory = proto::PageDirectory::create(*grid, about.pages);
  if (!directory.ok()) return directory.error();
  const uint64_t epoch_bytes = about.epochs ? about.epochs->bytes() : 0;
  if (about.shape.sparse_levels > 0 && epoch_bytes > 0)
    return Error{ErrorCode::kUnsupported, target.string() + ": a scene with sparse levels can have no epochs yet"};
  const Bytes text = encodeText(about.origin);
  if (text.size() > kMaxTextBytes)
    return Error{ErrorCode::kLimit, target.string() + ": more than 16 MiB of names and notes"};

  const bool is_stated =
      about.datum.vertical.zero_surface != proto::ZeroSurface::kUnstated || !about.datum.inputs.empty();
  const Bytes datum = is_stated ? encodeDatum(about.datum) : Bytes{};
  if (datum.size() > kMaxDatumBytes)
    return Error{ErrorCode::kLimit, target.string() + ": more than 32 MiB of inputs and undulations"};
  const FileLayout layout = FileLayout::of(about.shape, *directory,
                                           {.text = text.size(),
                                            .objects = about.objects.size(),
                                            .epochs = epoch_bytes,
                                            .tiles = about.tiles ? about.tiles->bytes() : 0,
                                            .datum = datum.size()});
  FileHeader h;
  h.file_bytes = layout.file_bytes;
  const proto::GridShape& s = about.shape;
  h.roots_x = s.roots_x, h.roots_y = s.roots_y, h.root_log2 = s.root_log2, h.samples_x = s.samples_x,
  h.samples_y = s.samples_y, h.sparse_levels = s.sparse_levels;
  putFrame(about.frame, h);
  h.lowest = about.heights.lowest, h.highest = about.heights.highest;
  h.voids_filled = about.origin.voids_filled;
  h.slot_count = grid->slotCount();
  for (uint32_t kind = 0; kind < kSectionCount; ++kind) h.sections[kind] = layout.sections[kind];
  h.epochs = layout.epochs;
  h.tiles = layout.tiles;
  h.datum = layout.datum;
  h.pages = layout.pages;
  h.epoch_blend = static_cast<uint32_t>(about.epoch_blend);
  h.version = versionFor(about, is_stated);
  h.page_coding = about.page_coding;
  h.has_sea = about.has_sea ? 1 : 0;

  auto file = NewFile::create(target, layout.file_bytes, about.mapping);
  if (!file.ok()) return file.error();
  SceneWriter writer(std::move(file).value(), layout, h);
  writer.target_ = target;
  writer.threads_ = about.threads;
  const std::pair<uint64_t, ByteSpan> parts[] = {{layout.sections[kText].offset, text},
                                                 {layout.sections[kObjects].offset, about.objects},
                                                 {layout.datum.offset, datum},
                                                 {layout.pages.offset, bytesOf(about.pages)}};
  for (const auto& [offset, bytes] : parts)
    if (Status status = writer.file_.put(offset, bytes); !status.ok()) return status.error();
  if (about.epochs) {
    const auto put = [&](uint64_t offset, ByteSpan what) {
      return writer.file_.put(layout.epochs.offset + offset, what);
    };
    if (Status status = about.epochs->write(put); !status.ok()) return status.error();
  }
  if (about.tiles) {
    const auto put = [&](uint64_t offset, ByteSpan what) {
      return writer.file_.put(layout.tiles.offset + offset, what);
    };
    if (Status status = about.tiles->write(put); !status.ok()) return status.error();
  }
  return writer;
}

std::span<const NodeRecord> SceneWriter::nodes() const {
  CHECK_TRUE(file_.data() != nullptr);
  const SectionRange& range = layout_.sections[kNodes];
  return {reinterpret_cast<const NodeRecord*>(file_.data() + range.offset), range.bytes / sizeof(NodeRecord)};
}

Status SceneWriter::put(uint64_t first, std::span<const NodeRecord> records) const {
  return file_.put(layout_.sections[kNodes].offset + first * sizeof(NodeRecord), bytesOf(records));
}

void SceneWriter::release(std::span<const NodeRecord> nodes) const { file_.release(bytesOf(nodes)); }

Status SceneWriter::putBases() const {
  if (Status s = file_.put(layout_.sections[kCorners].offset, bytesOf<int32_t>(corners_)); !s.ok()) return s;
  return file_.put(layout_.sections[kCentres].offset, bytesOf<int32_t>(centres_));
}

Result<uint64_t> SceneWriter::finish() {
  if (Status s = putBases(); !s.ok()) return s.error();
  if (header_.page_coding == PageCoding::kCoded) return finishCoded();
  return sealFile(file_, layout_.sections[kChecksums], header_);
}

Status SceneWriter::copyPart(const SectionRange& from, const NewFile& to, uint64_t offset) const {
  constexpr uint64_t kPiece = 1u << 22;
  Bytes piece;
  for (uint64_t at = 0; at < from.bytes; at += kPiece) {
    piece.resize(std::min(kPiece, from.bytes - at));
    if (Status s = file_.read(from.offset + at, piece); !s.ok()) return s;
    if (Status s = to.put(offset + at, piece); !s.ok()) return s;
  }
  return {};
}

// Everything but the pages is copied to another file, and the first one is given up. All of it goes piece by piece,
// whether the file is mapped or not.
Result<uint64_t> SceneWriter::finishCoded() {
  const auto grid = proto::GridTopology::create(header_.shape());
  CHECK_TRUE(grid.ok());
  std::vector<proto::PageBlock> blocks(header_.pages.bytes / sizeof(proto::PageBlock));
  if (Status s = file_.read(header_.pages.offset, writableBytesOf(std::span(blocks))); !s.ok()) return s.error();
  const auto directory = proto::PageDirectory::create(*grid, blocks);
  CHECK_TRUE(directory.ok());
  const proto::Frame frame = getFrame(header_);
  const CodedTerrain terrain{*grid, *directory, {}, {corners_, centres_}, frame};
  const auto read = [&](uint64_t first, std::span<NodeRecord> out) {
    return file_.read(layout_.sections[kNodes].offset + first * sizeof(NodeRecord), writableBytesOf(out));
  };
  const auto pages = CodedPagesWriter::create(terrain, read, target_, threads_);
  if (!pages.ok()) return pages.error();
  const FileLayout coded = FileLayout::of(grid->shape(), *directory,
                                          {.text = layout_.sections[kText].bytes,
                                           .objects = layout_.sections[kObjects].bytes,
                                           .epochs = layout_.epochs.bytes,
                                           .tiles = layout_.tiles.bytes,
                                           .datum = layout_.datum.bytes,
                                           .coded_pages = pages->bytes()});
  auto file = NewFile::create(target_, coded.file_bytes, FileMapping::kNone);
  if (!file.ok()) return file.error();
  const auto copy = [&](const SectionRange& from, const SectionRange& to) { return copyPart(from, *file, to.offset); };
  for (const SectionKind kind : {kText, kCorners, kCentres, kObjects})
    if (Status s = copy(layout_.sections[kind], coded.sections[kind]); !s.ok()) return s.error();
  for (const auto part : {&FileLayout::epochs, &FileLayout::tiles, &FileLayout::datum, &FileLayout::pages})
    if (Status s = copy(layout_.*part, coded.*part); !s.ok()) return s.error();
  const auto put = [&](uint64_t offset, ByteSpan what) {
    return file->put(coded.sections[kNodes].offset + offset, what);
  };
  if (Status s = pages->write(put); !s.ok()) return s.error();
  layout_ = coded;
  header_.file_bytes = coded.file_bytes;
  std::ranges::copy(coded.sections, header_.sections);
  header_.epochs = coded.epochs, header_.tiles = coded.tiles, header_.datum = coded.datum, header_.pages = coded.pages;
  return sealFile(*file, layout_.sections[kChecksums], header_);
}

}  // namespace foreland::terrain
