// Which files the readers of foreign formats may open. A file of a stranger may name others (a VRT its sources, an OBJ
// its materials, a glTF its buffers); these must lie in the folder of the file that the user named, or below, links
// resolved, unless the user has allowed another folder. So no input makes a program read what its user did not mean.
//
// Immutable after creation; any thread.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "base/result.h"

namespace foreland::terrain {

class FileFence {
 public:
  // What the user named, and folders allowed by --allow-files-from.
  explicit FileFence(std::span<const std::filesystem::path> inputs,
                     std::span<const std::filesystem::path> allowed = {});

  // Whether a file, which need not be there, may be read. O(folders), and the file system's work of resolving links.
  bool mayRead(const std::filesystem::path& file) const;
  // An absolute path without links, as far as it is there: folders() and files() are such. Empty if the file system
  // cannot tell where it leads: its name is too long, or its links go round. No such file may be read.
  static std::filesystem::path resolved(const std::filesystem::path& path);
  // What is said of a file that must not be read, and how to allow it.
  static Error refusal(const std::filesystem::path& by, const std::filesystem::path& file);

  const std::vector<std::filesystem::path>& folders() const { return folders_; }
  const std::vector<std::filesystem::path>& files() const { return files_; }

 private:
  std::vector<std::filesystem::path> folders_, files_;
};

}  // namespace foreland::terrain
