// A scene file mapped into memory: the Scene that the server reads, with the raw file for those who check it. Immutable
// after open; any thread. The file must not be changed in place while it is open; our writer never does (it replaces it
// by rename).
#pragma once

#include <filesystem>
#include <memory>

#include "terrain/store/format.h"
#include "terrain/store/mapped_file.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

class MappedScene final : public Scene {
 public:
  static Result<std::shared_ptr<const MappedScene>> open(const std::filesystem::path& path);
  const FileHeader& header() const { return header_; }
  ByteSpan file() const { return file_.span(); }

 private:
  MappedScene(MappedFile file, const FileHeader& header, proto::GridTopology grid);
  Status adopt();

  MappedFile file_;
  FileHeader header_;
};

}  // namespace foreland::terrain
