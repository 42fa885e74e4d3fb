// Finds the files that a model names: material libraries, buffers and textures. A model from a stranger must not make
// the program read other files, so what is found lies, links resolved, in the model's folder or below, or in a folder
// that the user allows. Names are taken as programs write them: with either slash, with blanks, in another case, or
// with the path on the author's machine, of which the last part is looked for beside the model. Reads directories and
// links, no file. One owner.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/fence/file_fence.h"

namespace foreland::terrain {

class Neighbours {
 public:
  // `allowed`: further folders than the model's (--allow-files-from).
  explicit Neighbours(std::filesystem::path model, const std::vector<std::filesystem::path>& allowed = {});

  // The file that `name` stands for. Relative names are looked for beside `namer`, the file that holds the name, then
  // beside the model, which is the namer by default. Error: it lies elsewhere, or there is none.
  [[nodiscard]] Result<std::filesystem::path> find(const std::string& name, const std::filesystem::path& namer = {});

 private:
  std::optional<std::filesystem::path> existing(const std::filesystem::path& path);

  std::filesystem::path model_;
  FileFence fence_;
  // Of folders that were searched: names in small letters, and as they are.
  std::map<std::filesystem::path, std::map<std::string, std::string>> listings_;
};

}  // namespace foreland::terrain
