// A scene file mapped into memory: the Scene that the server reads, with the raw file for those who check it. Immutable
// after open; any thread. The file must not be changed in place while it is open; our writer never does (it replaces it
// by rename).
#pragma once

#include <filesystem>
#include <memory>

#include "terrain/store/format.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

class MappedScene final : public Scene {
 public:
  static Result<std::shared_ptr<const MappedScene>> open(const std::filesystem::path& path);
  ~MappedScene() override;
  MappedScene(const MappedScene&) = delete;
  MappedScene& operator=(const MappedScene&) = delete;

  const FileHeader& header() const { return header_; }
  ByteSpan file() const { return file_; }
  std::span<const uint64_t> blockChecksums() const;

 private:
  MappedScene(ByteSpan file, const FileHeader& header, proto::GridTopology grid);
  Status adopt();
  template <class T>
  std::span<const T> section(SectionKind kind) const;

  ByteSpan file_;  // owned: unmapped by the destructor
  FileHeader header_;
};

}  // namespace foreland::terrain
