#include "terrain/model/neighbours.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "terrain/model/words.h"

namespace foreland::terrain {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxEntries = 100'000;  // of a folder that is searched without regard to case

// With forward slashes, and without quotes around it.
std::string plainName(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  return name;
}

// Whether the name is of a file on this machine; a drive's or a URL's is not.
bool isLocal(const std::string& name) { return name.substr(0, name.find('/')).find(':') == std::string::npos; }

bool isFile(const fs::path& path) {
  std::error_code failed;
  return fs::is_regular_file(path, failed);
}

fs::path resolved(const fs::path& path) {
  std::error_code failed;
  fs::path made = fs::weakly_canonical(path.empty() ? fs::path(".") : path, failed);
  return failed ? fs::path() : made;
}

bool isBelow(const fs::path& path, const fs::path& root) {
  return !root.empty() && std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first == root.end();
}

}  // namespace

Neighbours::Neighbours(fs::path folder, std::vector<fs::path> allowed) : folder_(std::move(folder)) {
  roots_.push_back(resolved(folder_));
  for (const fs::path& root : allowed) roots_.push_back(resolved(root / ""));
  for (fs::path& root : roots_)
    if (!root.has_filename()) root = root.parent_path();  // "a/" is "a"
}

bool Neighbours::isAllowed(const fs::path& file) const {
  const fs::path path = resolved(file);
  return std::any_of(roots_.begin(), roots_.end(), [&](const fs::path& root) { return isBelow(path, root); });
}

// The file of that name, whatever the case of the last part.
std::optional<fs::path> Neighbours::existing(const fs::path& path) {
  if (isFile(path)) return path;
  const fs::path folder = path.parent_path().empty() ? "." : path.parent_path();
  const auto [names, is_new] = listings_.try_emplace(folder);
  if (is_new) {
    std::error_code failed;
    fs::directory_iterator entry(folder, failed);
    for (int seen = 0; !failed && entry != fs::directory_iterator() && seen < kMaxEntries; ++seen) {
      const std::string name = entry->path().filename().string();
      names->second.try_emplace(lowered(name), name);
      entry.increment(failed);
    }
  }
  const auto found = names->second.find(lowered(path.filename().string()));
  if (found == names->second.end() || !isFile(folder / found->second)) return std::nullopt;
  return folder / found->second;
}

Result<fs::path> Neighbours::find(const std::string& written, const fs::path& namer) {
  const std::string name = plainName(written);
  const fs::path path(name), file = path.filename();
  std::vector<fs::path> candidates;
  if (isLocal(name)) candidates.push_back(namer.parent_path() / path), candidates.push_back(folder_ / path);
  candidates.push_back(namer.parent_path() / file), candidates.push_back(folder_ / file);
  bool is_outside = !isLocal(name);
  for (const fs::path& candidate : candidates) {
    if (file.empty() || name.find('\0') != std::string::npos) break;
    // Folders that are not allowed are not looked into: whether a file is there is none of the model's business.
    if (!isAllowed(candidate)) {
      is_outside = true;
      continue;
    }
    if (const auto found = existing(candidate); found && isAllowed(*found)) return *found;
  }
  const std::string shown = "'" + written.substr(0, 80) + "'";
  if (is_outside)
    return Error{ErrorCode::kUnsupported, "names the file " + shown +
                                              " outside its folder; put the file beside the model, or allow its folder "
                                              "with --allow-files-from DIR"};
  return Error{ErrorCode::kNotFound, (folder_ / path).string() + ": there is no such file; put it beside the model"};
}

}  // namespace foreland::terrain
