// A scene file mapped into memory: the Scene that the server reads, with the raw file for those who check it. Immutable
// after open; any thread. The file must not be changed in place while it is open; our writer never does (it replaces it
// by rename).
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "terrain/store/file/mapped_file.h"
#include "terrain/store/format.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

class MappedScene final : public Scene {
 public:
  // Of a scene whose pages are coded so many bytes of them are held inflated.
  static Result<std::shared_ptr<const MappedScene>> open(const std::filesystem::path& path,
                                                         uint64_t page_cache_bytes = kDefaultPageCacheBytes);
  // Opens a scene whose file is in memory, kept alive by `owner` and aligned to a page. Errors call the file `name`.
  // With a supply not all of it need be there (distant_scene.h).
  static Result<std::shared_ptr<const MappedScene>> of(ByteSpan bytes, const std::string& name,
                                                       std::shared_ptr<const void> owner,
                                                       uint64_t page_cache_bytes = kDefaultPageCacheBytes,
                                                       std::shared_ptr<const PageSupply> supply = nullptr);
  const FileHeader& header() const { return header_; }
  ByteSpan file() const { return bytes_; }

 private:
  MappedScene(ByteSpan bytes, std::shared_ptr<const void> owner, const FileHeader& header, proto::GridTopology grid);
  Status adopt(uint64_t page_cache_bytes);
  Status adoptRecords(uint64_t page_cache_bytes);
  Status readPages();

  template <class T>
  std::span<const T> section(SectionKind kind) const {
    return sectionOf<T>(bytes_, header_.sections[kind]);
  }

  ByteSpan bytes_;
  std::shared_ptr<const void> owner_;  // of the bytes
  FileHeader header_;
};

}  // namespace foreland::terrain
