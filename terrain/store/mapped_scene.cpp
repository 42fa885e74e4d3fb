#include "terrain/store/mapped_scene.h"

#include <algorithm>
#include <utility>

namespace foreland::terrain {

Result<std::shared_ptr<const MappedScene>> MappedScene::open(const std::filesystem::path& path,
                                                             uint64_t page_cache_bytes) {
  return openMapped<MappedScene>(path, page_cache_bytes);
}

Result<std::shared_ptr<const MappedScene>> MappedScene::of(ByteSpan bytes, const std::string& name,
                                                           std::shared_ptr<const void> owner, uint64_t page_cache_bytes,
                                                           std::shared_ptr<const PageSupply> supply) {
  if (bytes.size() < kPageBytes) return damagedFile(name, "it is cut short");
  const auto header = readHeader<FileHeader>(bytes, name);
  if (!header.ok()) return header.error();
  auto grid = proto::GridTopology::create(header->shape());
  if (!grid.ok()) return damagedFile(name, grid.error().message);
  if (Status frame = getFrame(*header).validate(grid->maxX(), grid->maxY()); !frame.ok())
    return damagedFile(name, frame.error().message);
  std::shared_ptr<MappedScene> scene(new MappedScene(bytes, std::move(owner), *header, *grid));
  scene->supply_ = std::move(supply);
  if (const Status status = scene->adopt(page_cache_bytes); !status.ok())
    return damagedFile(name, status.error().message);
  return std::shared_ptr<const MappedScene>(std::move(scene));
}

MappedScene::MappedScene(ByteSpan bytes, std::shared_ptr<const void> owner, const FileHeader& header,
                         proto::GridTopology grid)
    : Scene(std::move(grid), getFrame(header)), bytes_(bytes), owner_(std::move(owner)), header_(header) {}

// Reads which pages are there, which decides where all other sections are.
Status MappedScene::readPages() {
  const auto malformed = [](const char* what) { return Error{ErrorCode::kMalformed, what}; };
  const SectionRange& at = header_.pages;
  if (header_.version <= FileHeader::kPlainVersion &&
      (header_.version > FileHeader::kWholeVersion) != (header_.sparse_levels > 0))
    return malformed("its version does not go with its sparse levels");
  if (header_.sparse_levels > 0 && header_.epochs.bytes > 0)
    return malformed("it has sparse levels with epochs, which this version cannot read");
  if (at.bytes == 0) return adoptPages({});
  if (header_.sparse_levels == 0 || at.bytes % sizeof(proto::PageBlock) != 0)
    return malformed("its directory of pages has a wrong size");
  if (at.offset % kPageBytes != 0 || at.offset > bytes_.size() || at.bytes > bytes_.size() - at.offset)
    return malformed("its directory of pages is not in the file");
  return adoptPages(sectionOf<proto::PageBlock>(bytes_, at));
}

// Checks the header against the sizes that follow from its grid, then points the spans into the file.
Status MappedScene::adopt(uint64_t page_cache_bytes) {
  const auto malformed = [](const char* what) { return Error{ErrorCode::kMalformed, what}; };
  const uint64_t text_bytes = header_.sections[kText].bytes;
  if (text_bytes > kMaxTextBytes) return malformed("its text is too long");
  const uint64_t object_bytes = header_.sections[kObjects].bytes;
  if (object_bytes > bytes_.size()) return malformed("its objects are too large");
  const uint64_t epoch_bytes = header_.epochs.bytes;
  if (epoch_bytes > bytes_.size()) return malformed("its epochs are too large");
  const uint64_t tile_bytes = header_.tiles.bytes;
  if (tile_bytes > bytes_.size()) return malformed("its tiles are too large");
  if (header_.version == FileHeader::kOldestVersion && tile_bytes > 0) return malformed("it is too old to have tiles");
  const uint64_t datum_bytes = header_.datum.bytes;
  if (datum_bytes > std::min<uint64_t>(bytes_.size(), kMaxDatumBytes))
    return malformed("its vertical datum is too large");
  if (header_.version <= FileHeader::kWholeVersion &&
      (header_.version > FileHeader::kUnstatedVersion) != (datum_bytes > 0))
    return malformed("its version does not go with its vertical datum");
  const bool are_coded = header_.page_coding == PageCoding::kCoded;
  if ((header_.version > FileHeader::kPlainVersion) != are_coded)
    return malformed("its version does not go with how its pages are coded");
  if (header_.has_sea > (frame_.kind == proto::FrameKind::kGlobe ? 1 : 0))
    return malformed("it has a sea that this version does not know");
  has_sea_ = header_.has_sea == 1;
  const uint64_t page_bytes = are_coded ? header_.sections[kNodes].bytes : 0;
  if (page_bytes > bytes_.size()) return malformed("its coded pages are too large");
  if (Status pages = readPages(); !pages.ok()) return pages;
  const FileLayout layout = FileLayout::of(grid_.shape(), directory_,
                                           {.text = text_bytes,
                                            .objects = object_bytes,
                                            .epochs = epoch_bytes,
                                            .tiles = tile_bytes,
                                            .datum = datum_bytes,
                                            .coded_pages = page_bytes});
  for (uint32_t kind = 0; kind < kSectionCount; ++kind)
    if (header_.sections[kind] != layout.sections[kind]) return malformed("its sections are not where they belong");
  if (header_.epochs != layout.epochs) return malformed("its epochs are not where they belong");
  if (header_.tiles != layout.tiles) return malformed("its tiles are not where they belong");
  if (header_.datum != layout.datum) return malformed("its vertical datum is not where it belongs");
  if (header_.pages != layout.pages) return malformed("its directory of pages is not where it belongs");
  if (header_.file_bytes != layout.file_bytes || header_.slot_count != grid_.slotCount() ||
      header_.lowest > header_.highest)
    return malformed("its sizes contradict each other");
  const auto table = section<uint8_t>(kChecksums);
  if (contentId(header_, table) != header_.scene_id) return malformed("its table of checksums is damaged");

  if (Status text = decodeText(section<uint8_t>(kText), origin_); !text.ok()) return text;
  origin_.voids_filled = header_.voids_filled;
  id_ = header_.scene_id;
  heights_ = {header_.lowest, header_.highest};
  corners_ = section<int32_t>(kCorners);
  centres_ = section<int32_t>(kCentres);
  objects_ = section<uint8_t>(kObjects);
  const auto blend = proto::epochBlendOf(header_.epoch_blend);
  if (!blend) return malformed("its epochs are blended in an unknown way");
  if (header_.version <= FileHeader::kLinearVersion && *blend != proto::EpochBlend::kLinear)
    return malformed("it is too old to blend epochs but linearly");
  auto epochs = EpochTable::read(grid_, sectionOf<uint8_t>(bytes_, header_.epochs), *blend);
  if (!epochs) return epochs.error();
  epochs_ = std::move(*epochs);
  auto tiles = TileTable::read(sectionOf<uint8_t>(bytes_, header_.tiles), frame_.face_steps);
  if (!tiles) return tiles.error();
  tiles_ = std::move(*tiles);
  if (datum_bytes > 0) {
    auto datum = decodeDatum(sectionOf<uint8_t>(bytes_, header_.datum), header_.samples_x, header_.samples_y);
    if (!datum) return datum.error();
    datum_ = std::move(*datum);
  }
  if (datum_.vertical.zero_surface == proto::ZeroSurface::kUnstated)
    datum_.vertical = datumOfReferenceSystem(origin_.crs_wkt);
  const auto isAbsurd = [](int32_t h) { return h < -proto::kMaxHeight || h > proto::kMaxHeight; };
  if (std::any_of(corners_.begin(), corners_.end(), isAbsurd) ||
      std::any_of(centres_.begin(), centres_.end(), isAbsurd))
    return malformed("a base vertex is absurdly high or low");
  return adoptRecords(page_cache_bytes);
}

Status MappedScene::adoptRecords(uint64_t page_cache_bytes) {
  if (header_.page_coding == PageCoding::kPlain) {
    records_ = section<NodeRecord>(kNodes);
    return {};
  }
  const CodedTerrain terrain{grid_, directory_, {}, {corners_, centres_}, frame_};
  auto coded = CodedPages::open(terrain, section<uint8_t>(kNodes), page_cache_bytes);
  if (!coded) return coded.error();
  coded_ = std::move(*coded);
  records_ = coded_->records();
  return {};
}

}  // namespace foreland::terrain
