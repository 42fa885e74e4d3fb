// The files that a globe was made of, as it was made of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/options/foreign_files.h"
#include "base/result.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

struct GlobeInputs {
  std::vector<std::filesystem::path> base;
  terrain::OpenOptions open;  // with the others as insets
};

// In the order of the scene's inputs, each above what the scene states of it, unless it is followed by @vertical=...,
// as for `foreland build`. An Error: a file that the scene does not name, or an input that is not given.
Result<GlobeInputs> globeInputs(const terrain::Scene& scene, const std::vector<std::string>& sources,
                                const ForeignFiles& foreign);

// All files that sources name, those that heights count from among them.
std::vector<std::filesystem::path> filesOfSources(const std::vector<std::string>& sources);

}  // namespace foreland::apps
