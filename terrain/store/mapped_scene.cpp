#include "terrain/store/mapped_scene.h"

#include <utility>

namespace foreland::terrain {

Result<std::shared_ptr<const MappedScene>> MappedScene::open(const std::filesystem::path& path) {
  auto file = MappedFile::open(path);
  if (!file.ok()) return file.error();
  const auto header = readHeader<FileHeader>(file->span(), path);
  if (!header.ok()) return header.error();
  auto grid = proto::GridTopology::create(
      {header->roots_x, header->roots_y, header->root_log2, header->samples_x, header->samples_y});
  if (!grid.ok()) return damagedFile(path, grid.error().message);
  std::shared_ptr<MappedScene> scene(new MappedScene(std::move(file).value(), *header, *grid));
  if (const Status status = scene->adopt(); !status.ok()) return damagedFile(path, status.error().message);
  return std::shared_ptr<const MappedScene>(std::move(scene));
}

MappedScene::MappedScene(MappedFile file, const FileHeader& header, proto::GridTopology grid)
    : Scene(std::move(grid), getFrame(header)), file_(std::move(file)), header_(header) {}

// Checks what the header says against what it must say, then points the spans into the file.
Status MappedScene::adopt() {
  const auto malformed = [](const char* what) { return Error{ErrorCode::kMalformed, what}; };
  if (Status frame = frame_.validate(grid_.maxX(), grid_.maxY()); !frame.ok()) return frame;
  const uint64_t text_bytes = header_.sections[kText].bytes;
  if (text_bytes > kMaxTextBytes) return malformed("its text is too long");
  const uint64_t object_bytes = header_.sections[kObjects].bytes;
  if (object_bytes > file_.span().size()) return malformed("its objects are too large");
  const FileLayout layout = FileLayout::of(grid_, text_bytes, object_bytes);
  for (uint32_t kind = 0; kind < kSectionCount; ++kind)
    if (header_.sections[kind] != layout.sections[kind]) return malformed("its sections are not where they belong");
  if (header_.file_bytes != layout.file_bytes || header_.slot_count != grid_.slotCount() ||
      header_.lowest > header_.highest)
    return malformed("its sizes contradict each other");
  const auto table = file_.section<uint8_t>(header_.sections[kChecksums]);
  if (contentId(header_, table) != header_.scene_id) return malformed("its table of checksums is damaged");

  if (Status text = decodeText(file_.section<uint8_t>(header_.sections[kText]), origin_); !text.ok()) return text;
  origin_.voids_filled = header_.voids_filled;
  id_ = header_.scene_id;
  heights_ = {header_.lowest, header_.highest};
  nodes_ = file_.section<NodeRecord>(header_.sections[kNodes]);
  corners_ = file_.section<int32_t>(header_.sections[kCorners]);
  centres_ = file_.section<int32_t>(header_.sections[kCentres]);
  objects_ = file_.section<uint8_t>(header_.sections[kObjects]);
  return {};
}

}  // namespace foreland::terrain
