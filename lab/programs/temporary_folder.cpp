#include "lab/programs/temporary_folder.h"

#include <stdlib.h>

#include <string>
#include <system_error>

namespace foreland::lab {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::error_code ignored;
  std::string pattern = (fs::temp_directory_path(ignored) / "foreland-bench-XXXXXX").string();
  if (::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

}  // namespace foreland::lab
