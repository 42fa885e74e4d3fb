#include "apps/verify/verify_globe.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/globe_inputs.h"
#include "terrain/dem/open_globe.h"
#include "terrain/pipeline/globe_residual.h"

namespace foreland::apps {

namespace {

constexpr double kMeasuredInFloats_m = 1e-3;  // of floats that heights were in when the residual was measured

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
  auto inputs_of = globeInputs(scene, sources, foreign);
  if (!inputs_of.ok()) return inputs_of.error();
  auto& [base, open] = *inputs_of;
  auto source = terrain::openGlobe(base, open);
  // By default each inset has a feather of its own; an option says one for all.
  if (source.ok() && !hasFeathersOf(scene, (*source)->info())) {
    open.feather_m = std::ranges::max(scene.inputs(), {}, &terrain::SceneInput::feather_m).feather_m;
    source = terrain::openGlobe(base, open);
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
