// Writes the scene file of a terrain, whole or not at all (new_file.h).
//
// One owner; put() may be called by several threads at once.
#pragma once

#include <filesystem>
#include <span>
#include <utility>

#include "base/result.h"
#include "terrain/store/file/new_file.h"
#include "terrain/store/format.h"
#include "terrain/store/scene.h"
#include "terrain/store/tables/tile_section.h"

namespace foreland::terrain {

class SceneWriter {
 public:
  // What the header says. Shape and frame must be valid.
  struct About {
    proto::GridShape shape;
    proto::Frame frame;
    HeightRange heights;
    SceneOrigin origin;
    Bytes objects{};  // the section of objects (terrain/objects)
    Bytes epochs{};   // the section of epochs (epoch_section.h)
    proto::EpochBlend epoch_blend = proto::EpochBlend::kLinear;
    const TileSection* tiles = nullptr;
  };
  static Result<SceneWriter> create(const std::filesystem::path& target, const About& about);

  std::span<const NodeRecord> nodes() const;  // zero until put()
  std::span<int32_t> corners();
  std::span<int32_t> centres();
  uint64_t fileBytes() const { return layout_.file_bytes; }

  // Writes records from slot `first` on; nodes() shows them.
  Status put(proto::Slot first, std::span<const NodeRecord> records) const;
  // Lets the pages of nodes() leave this process's memory; their content stays in the file.
  void release(std::span<const NodeRecord> nodes) const;

  // Writes checksums and header, flushes to the disk and names the file. Returns the scene's id. Call once, when
  // everything is filled.
  Result<uint64_t> finish();

 private:
  SceneWriter(NewFile file, const FileLayout& layout, const FileHeader& header)
      : file_(std::move(file)), layout_(layout), header_(header) {}
  uint8_t* at(SectionKind kind) const { return file_.data() + layout_.sections[kind].offset; }
  uint8_t* at(const SectionRange& range) const { return file_.data() + range.offset; }

  NewFile file_;
  FileLayout layout_;
  FileHeader header_;
};

}  // namespace foreland::terrain
