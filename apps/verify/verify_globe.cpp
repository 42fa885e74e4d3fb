#include "apps/verify/verify_globe.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "terrain/dem/open_globe.h"
#include "terrain/dem/vertical/height_reference.h"
#include "terrain/pipeline/globe_residual.h"

namespace foreland::apps {

namespace {

constexpr double kMeasuredInFloats_m = 1e-3;  // of floats that heights were in when the residual was measured
constexpr std::string_view kAboveWhat = "@vertical=";

std::string fileIn(const std::string& source) { return source.substr(0, source.rfind(kAboveWhat)); }

// As the globe was opened: the base's files are those without voids.
Result<std::vector<std::filesystem::path>> arrange(const terrain::Scene& scene, const std::vector<std::string>& sources,
                                                   terrain::OpenOptions& open) {
  std::vector<std::filesystem::path> base;
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
      open.vertical_of[file] = source->substr(file.size() + kAboveWhat.size());
    else if (!stated.empty())
      open.vertical_of[file] = stated;
    if (input.may_have_voids)
      open.insets.push_back({file, 0});
    else
      base.emplace_back(file);
  }
  if (const auto unused = std::ranges::find(is_used, false); unused != is_used.end())
    return Error{ErrorCode::kInvalidArgument, fileIn(sources[static_cast<size_t>(unused - is_used.begin())]) +
                                                  ": the scene names no such input; see foreland info"};
  return base;
}

bool hasFeathersOf(const terrain::Scene& scene, const terrain::GlobeInfo& info) {
  for (const terrain::GlobeInput& input : info.inputs)
    for (const std::string& file : input.files) {
      const auto stated = std::ranges::find(scene.inputs(), file, &terrain::SceneInput::name);
      if (stated != scene.inputs().end() && std::fabs(stated->feather_m - input.feather_m) > 1e-6) return false;
    }
  return true;
}

bool judge(const std::string& name, double found_m, double stated_m) {
  std::printf("%s: where it alone counts within %.4g m, %.4g m are stated\n", name.c_str(), found_m, stated_m);
  if (found_m <= stated_m + kMeasuredInFloats_m) return true;
  std::fprintf(stderr, "foreland verify: %s: the scene is %.4g m off it, and states %.4g m\n", name.c_str(), found_m,
               stated_m);
  return false;
}

}  // namespace

Result<uint64_t> verifyGlobeSources(const terrain::Scene& scene, const std::vector<std::string>& sources,
                                    const ForeignFiles& foreign) {
  terrain::OpenOptions open;
  open.allowed_folders = foreign.allowed;
  const auto base = arrange(scene, sources, open);
  if (!base.ok()) return base.error();
  auto source = terrain::openGlobe(*base, open);
  // By default each inset has a feather of its own; an option says one for all.
  if (source.ok() && !hasFeathersOf(scene, (*source)->info())) {
    open.feather_m = std::ranges::max(scene.inputs(), {}, &terrain::SceneInput::feather_m).feather_m;
    source = terrain::openGlobe(*base, open);
  }
  if (!source.ok()) return source.error();
  std::vector<proto::Slot> pages;
  for (const proto::PageBlock& block : scene.pages().blocks())
    scene.pages().forEachPage(block, [&](proto::Slot first, uint64_t) { pages.push_back(first); });
  const auto found = terrain::globeResiduals(
      **source, scene.grid(), scene.frame(), pages, [&](proto::NodeId n) { return scene.height(n); }, 0,
      [](double) { return true; });
  CHECK_TRUE(found.has_value());
  uint64_t faults = 0;
  const auto& inputs = (*source)->info().inputs;
  for (size_t i = 0; i < inputs.size(); ++i)
    for (const std::string& file : inputs[i].files) {
      const auto stated = std::ranges::find(scene.inputs(), file, &terrain::SceneInput::name);
      if (stated != scene.inputs().end()) faults += judge(file, (*found)[i], stated->residual_m) ? 0 : 1;
    }
  return faults;
}

}  // namespace foreland::apps
