// The files of features that `foreland serve --overlay` gives to every page. The server checks that they may be what
// they are called and are not too large; pages read them, in a worker of their own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/result.h"

namespace foreland::apps {

// What a page reads at most: client/web/src/overlay/file_kinds.ts.
constexpr uint64_t kMaxOverlayBytes = 64u << 20;
constexpr uint64_t kMaxOverlaysBytes = 256u << 20;  // of all together, which stay in memory

// Their contents by paths in URLs, and /overlays/list.json, which tells pages of them; that alone if there are no
// files. An Error names the file and the way out. Reads the files whole.
Result<std::map<std::string, std::string>> overlayFiles(const std::vector<std::filesystem::path>& paths);

}  // namespace foreland::apps
