#include "lab/programs/lab_folder.h"

#include <system_error>

namespace foreland::lab {
namespace {

namespace fs = std::filesystem;

fs::path installedFolder() {
  std::error_code ignored;
  return (fs::read_symlink("/proc/self/exe", ignored).parent_path() / FORELAND_DATA / "lab").lexically_normal();
}

bool isInstalled() {
  std::error_code ignored;
  return fs::is_directory(installedFolder(), ignored);
}

}  // namespace

fs::path labFolder() { return isInstalled() ? installedFolder() : fs::path(FORELAND_SOURCE_DIR) / "lab"; }

fs::path wasmModulePath(const std::string& name) {
  const fs::path folder = isInstalled() ? installedFolder() / "wasm" : fs::path(FORELAND_SOURCE_DIR) / "build/wasm/bin";
  return folder / (name + ".wasm");
}

}  // namespace foreland::lab
