// SceneWriter writes the scene file of a terrain. The file appears whole or not at all (new_file.h).
//
// A writer has one owner; put() may be called by several threads at once.
#pragma once

#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "base/result.h"
#include "terrain/store/file/new_file.h"
#include "terrain/store/format.h"
#include "terrain/store/scene.h"
#include "terrain/store/tables/epoch_section.h"
#include "terrain/store/tables/tile_section.h"

namespace foreland::terrain {

class SceneWriter {
 public:
  // About holds what the file says beside nodes and base heights. create() returns an Error if the shape, the frame
  // or the pages are invalid, or if the origin's text exceeds 16 MiB.
  struct About {
    proto::GridShape shape;
    proto::Frame frame;
    HeightRange heights;
    SceneOrigin origin;
    Bytes objects{};                       // terrain/objects encodes this section of the file.
    const EpochSection* epochs = nullptr;  // Null of a scene that does not change; create() alone reads it.
    proto::EpochBlend epoch_blend = proto::EpochBlend::kLinear;
    SceneDatum datum{};    // Written if it is stated.
    bool has_sea = false;  // Of globes: viewers draw it (Scene::hasSea).
    PageCoding page_coding = PageCoding::kPlain;
    unsigned threads = 0;                // that code pages; 0: one per processor
    const TileSection* tiles = nullptr;  // A scene without tiles has none; create() alone reads it.
    // The pages that are there of the sparse levels (proto::blocksOf); create() alone reads it.
    std::span<const proto::PageBlock> pages{};
    FileMapping mapping = FileMapping::kMapped;
  };
  static Result<SceneWriter> create(const std::filesystem::path& target, const About& about);

  // By place. The records are zero until put() writes them. A file that is not mapped has none to look at. The caller
  // fills corners() and centres(), which are zero at first.
  std::span<const NodeRecord> nodes() const;
  std::span<int32_t> corners() { return corners_; }
  std::span<int32_t> centres() { return centres_; }
  uint64_t fileBytes() const { return layout_.file_bytes; }

  // Writes records from place `first` on (proto::PageDirectory), which is their slot where all levels are whole;
  // nodes() then shows the new records.
  Status put(uint64_t first, std::span<const NodeRecord> records) const;
  // Lets the pages of `nodes`, a part of nodes(), leave this process's memory; their content stays in the file.
  void release(std::span<const NodeRecord> nodes) const;

  // Codes the pages if they are to be, writes checksums and header, flushes the file to the disk and gives it its name.
  // Returns the scene's id. Must be called once, when nodes, corners and centres are filled; nothing of the above may
  // be called afterwards but fileBytes(). While pages are coded both files are on the disk.
  Result<uint64_t> finish();

 private:
  SceneWriter(NewFile file, const FileLayout& layout, const FileHeader& header)
      : file_(std::move(file)),
        layout_(layout),
        header_(header),
        corners_(layout.sections[kCorners].bytes / sizeof(int32_t)),
        centres_(layout.sections[kCentres].bytes / sizeof(int32_t)) {}
  Status putBases() const;
  Status copyPart(const SectionRange& from, const NewFile& to, uint64_t offset) const;
  Result<uint64_t> finishCoded();

  std::filesystem::path target_;
  unsigned threads_ = 0;
  NewFile file_;
  FileLayout layout_;
  FileHeader header_;
  std::vector<int32_t> corners_, centres_;
};

}  // namespace foreland::terrain
