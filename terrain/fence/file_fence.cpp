#include "terrain/fence/file_fence.h"

#include <algorithm>
#include <system_error>

namespace foreland::terrain {

namespace {

bool isWithin(const std::filesystem::path& file, const std::filesystem::path& folder) {
  const auto [end, at] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return end == folder.end() || (std::next(end) == folder.end() && end->empty());
}

}  // namespace

std::filesystem::path FileFence::resolved(const std::filesystem::path& path) {
  std::error_code failed;
  const std::filesystem::path absolute = std::filesystem::absolute(path, failed);
  if (failed) return {};
  std::filesystem::path out = std::filesystem::weakly_canonical(absolute, failed);
  return failed ? std::filesystem::path() : out;
}

// The folder of a link that the user named counts, and that of the file it leads to. The root of all files is no folder
// of an input's: only the input itself may be read there.
FileFence::FileFence(std::span<const std::filesystem::path> inputs, std::span<const std::filesystem::path> allowed) {
  for (const std::filesystem::path& input : inputs) {
    const std::filesystem::path file = resolved(input);
    if (file.empty()) continue;  // nor can it be opened
    files_.push_back(file);
    std::error_code failed;
    for (const std::filesystem::path& folder :
         {file.parent_path(), resolved(std::filesystem::absolute(input, failed).parent_path())})
      if (!folder.empty() && folder != folder.root_path() && std::ranges::find(folders_, folder) == folders_.end())
        folders_.push_back(folder);
  }
  for (const std::filesystem::path& folder : allowed)
    if (const std::filesystem::path known = resolved(folder); !known.empty()) folders_.push_back(known);
}

bool FileFence::mayRead(const std::filesystem::path& path) const {
  const std::filesystem::path file = resolved(path);
  if (file.empty()) return false;
  return std::ranges::find(files_, file) != files_.end() ||
         std::ranges::any_of(folders_, [&](const auto& folder) { return isWithin(file, folder); });
}

Error FileFence::refusal(const std::filesystem::path& by, const std::filesystem::path& named) {
  const std::filesystem::path known = resolved(named), &file = known.empty() ? named : known;
  return {ErrorCode::kInvalidArgument,
          by.string() + ": would read " + file.string() +
              ", which is outside of its folder; if you trust it, say --allow-files-from " +
              file.parent_path().string()};
}

}  // namespace foreland::terrain
