#include "terrain/model/neighbours.h"

#include <algorithm>
#include <optional>
#include <span>
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

}  // namespace

Neighbours::Neighbours(fs::path model, const std::vector<fs::path>& allowed)
    : model_(std::move(model)), fence_(std::span(&model_, 1), allowed) {}

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
  const fs::path path(name), file = path.filename(), folder = model_.parent_path(),
                             beside = namer.empty() ? folder : namer.parent_path();
  const bool is_name = !file.empty() && name.find('\0') == std::string::npos;
  std::vector<fs::path> candidates;
  if (isLocal(name)) candidates = {beside / path, folder / path};
  candidates.insert(candidates.end(), {beside / file, folder / file});
  std::optional<fs::path> outside;
  for (const fs::path& candidate : candidates) {
    if (!is_name) break;
    // Folders that are not allowed are not looked into: whether a file is there is none of the model's business.
    const auto found = fence_.mayRead(candidate) ? existing(candidate) : candidate;
    if (found && fence_.mayRead(*found)) return *found;
    if (found && !outside) outside = *found;
  }
  if (outside) return FileFence::refusal(namer.empty() ? model_ : namer, *outside);
  if (is_name && isLocal(name))
    return Error{ErrorCode::kNotFound, (folder / path).string() + ": there is no such file; put it beside the model"};
  return Error{ErrorCode::kUnsupported,
               "names '" + written.substr(0, 80) + "', which is no file of its folder; put the file beside the model"};
}

}  // namespace foreland::terrain
