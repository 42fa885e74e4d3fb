#include "server/net/http/scene_paths.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace foreland::server {
namespace {

constexpr size_t kLongest = 64;
constexpr std::array<std::string_view, 7> kOwnPaths = {"assets",  "fly",    "healthz", "livez",
                                                       "metrics", "readyz", "scenes"};

Error refusal(const std::string& name, const std::string& why) {
  return {ErrorCode::kInvalidArgument, "a scene cannot have the address '/" + name + "/': " + why +
                                           "; rename its file, or give the name of a link to it (ln -s)"};
}

bool isPlain(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_' || c == '-'; }

}  // namespace

Status checkSceneNames(std::span<const std::string> names) {
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    if (name.empty() || name.size() > kLongest) return refusal(name, "it has to have 1 to 64 characters");
    if (!std::ranges::all_of(name, isPlain) || name.front() == '.')
      return refusal(name, "letters, digits, '_', '-' and, not at its beginning, '.' will do");
    if (std::ranges::find(kOwnPaths, name) != kOwnPaths.end()) return refusal(name, "the server answers that itself");
    if (std::find(names.begin(), names.begin() + static_cast<ptrdiff_t>(i), name) !=
        names.begin() + static_cast<ptrdiff_t>(i))
      return refusal(name, "another scene has it");
  }
  return {};
}

std::optional<ScenePath> scenePathOf(std::string_view path, std::span<const std::string> names) {
  if (names.empty()) return ScenePath{0, path};
  if (path.empty() || path.front() != '/') return std::nullopt;
  const size_t end = std::min(path.find('/', 1), path.size());
  const auto found = std::ranges::find(names, path.substr(1, end - 1));
  if (found == names.end()) return std::nullopt;
  return ScenePath{static_cast<size_t>(found - names.begin()), path.substr(end)};
}

std::optional<size_t> sceneToFly(std::string_view target, std::span<const std::string> names) {
  if (names.empty()) return 0;
  const auto path = scenePathOf(target.substr(0, target.find_first_of("?#")), names);
  if (!path || (!path->rest.empty() && path->rest != "/" && path->rest != "/fly")) return std::nullopt;
  return path->scene;
}

}  // namespace foreland::server
