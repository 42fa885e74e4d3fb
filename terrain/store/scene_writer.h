// Writes a scene file whole or not at all: the file has no name until it is complete and on the disk (O_TMPFILE; where
// the file system has no unnamed files, a hidden temporary name that is removed on failure), then it replaces the
// target in one rename. Space is reserved before anything is written, so a full disk is an Error and never a signal.
//
// One owner; put() may be called by several threads at once.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "base/result.h"
#include "terrain/store/format.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

class SceneWriter {
 public:
  // What stands in the header; shape and frame are validated.
  struct About {
    proto::GridShape shape;
    proto::Frame frame;
    HeightRange heights;
    SceneOrigin origin;
  };
  static Result<SceneWriter> create(const std::filesystem::path& target, const About& about);

  SceneWriter(SceneWriter&& other) noexcept;
  SceneWriter& operator=(SceneWriter&&) = delete;
  ~SceneWriter();

  std::span<const NodeRecord> nodes() const;  // zero at first
  std::span<int32_t> corners();
  std::span<int32_t> centres();
  uint64_t fileBytes() const { return layout_.file_bytes; }

  // Writes records from slot `first`; nodes() shows them. Written rather than stored through the mapping: a third of
  // the cost.
  Status put(proto::Slot first, std::span<const NodeRecord> records) const;
  // Lets the pages of nodes() leave this process's memory; their content stays in the file.
  void release(std::span<const NodeRecord> nodes) const;

  // Checksums, header, disk, name. Returns the scene's id. Call once, when everything is filled.
  Result<uint64_t> finish();

 private:
  SceneWriter() = default;
  Status openTemporary();
  Status reserve();
  Status name();
  uint8_t* at(SectionKind kind) const { return data_ + layout_.sections[kind].offset; }
  Error systemError(const std::string& doing) const;

  std::filesystem::path target_, temporary_;  // temporary_ is empty while the file has no name
  int file_ = -1;
  uint8_t* data_ = nullptr;
  FileLayout layout_;
  FileHeader header_;
};

}  // namespace foreland::terrain
