#include "apps/globe_inputs.h"

#include <algorithm>
#include <string_view>

#include "terrain/dem/vertical/height_reference.h"

namespace foreland::apps {

namespace {

constexpr std::string_view kAboveWhat = "@vertical=";

std::string fileIn(const std::string& source) { return source.substr(0, source.rfind(kAboveWhat)); }

}  // namespace

// The base's files are those without voids.
Result<GlobeInputs> globeInputs(const terrain::Scene& scene, const std::vector<std::string>& sources,
                                const ForeignFiles& foreign) {
  GlobeInputs out;
  out.open.allowed_folders = foreign.allowed;
  std::vector<bool> is_used(sources.size());
  for (const terrain::SceneInput& input : scene.inputs()) {
    const auto of = [&](const std::string& s) { return std::filesystem::path(fileIn(s)).filename() == input.name; };
    const auto source = std::ranges::find_if(sources, of);
    if (source == sources.end())
      return Error{ErrorCode::kInvalidArgument,
                   input.name +
                       ": the globe was made of it, too, and it is not given; where one input alone counts "
                       "depends on all, so give each with a --source of its own"};
    is_used[static_cast<size_t>(source - sources.begin())] = true;
    const std::string file = fileIn(*source), stated = terrain::choiceNamed(input.vertical);
    if (file.size() < source->size())
      out.open.vertical_of[file] = source->substr(file.size() + kAboveWhat.size());
    else if (!stated.empty())
      out.open.vertical_of[file] = stated;
    if (input.may_have_voids)
      out.open.insets.push_back({file, 0});
    else
      out.base.emplace_back(file);
  }
  if (const auto unused = std::ranges::find(is_used, false); unused != is_used.end())
    return Error{ErrorCode::kInvalidArgument, fileIn(sources[static_cast<size_t>(unused - is_used.begin())]) +
                                                  ": the scene names no such input; see foreland info"};
  return out;
}

std::vector<std::filesystem::path> filesOfSources(const std::vector<std::string>& sources) {
  std::vector<std::filesystem::path> files;
  for (const std::string& source : sources) {
    const size_t at = source.rfind(kAboveWhat);
    files.emplace_back(source.substr(0, at));
    if (at != std::string::npos) files.emplace_back(source.substr(at + kAboveWhat.size()));
  }
  std::erase_if(files, [](const std::filesystem::path& file) { return terrain::isNamedDatum(file.string()); });
  return files;
}

}  // namespace foreland::apps
