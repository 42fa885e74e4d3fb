// What a scene is to have beside its ground, and how that stands in the file, on command lines: foreland build takes
// it, and so does foreland plan, whose words foreland merge reads again.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/pictures/open_pictures.h"
#include "terrain/elevation_source.h"
#include "terrain/imagery/imagery.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/pipeline/build.h"
#include "terrain/store/format.h"

namespace foreland::apps {

struct SceneArguments {
  terrain::PageCoding page_coding = terrain::PageCoding::kPlain;
  std::vector<std::string> objects;
  std::vector<std::filesystem::path> imagery;
  int imagery_quality = terrain::kDefaultImageryQuality;
  terrain::AlphaChoice imagery_alpha = terrain::AlphaChoice::kAuto;
  std::string attribution;
};

// The options; `arguments` must live until the command line is parsed.
void describeAdditions(CLI::App& app, SceneArguments& arguments);

// All files that the options name, for reading: pictures, then models. Some may not be there.
std::vector<std::filesystem::path> filesOf(const SceneArguments& arguments);

// Whether none of the pictures is the file that is to be written.
Status checkApart(const std::filesystem::path& output, const SceneArguments& arguments);

Result<std::vector<terrain::ObjectRequest>> parseObjects(const SceneArguments& arguments);

struct OpenedAdditions {
  std::unique_ptr<terrain::PictureSource> picture;  // null if there are none
  terrain::SceneAdditions additions;                // with it
};
// Lays the pictures on the lattice of the ground.
Result<OpenedAdditions> openAdditions(const SceneArguments& arguments, const terrain::ElevationInfo& ground,
                                      const std::vector<std::filesystem::path>& allowed_folders);

}  // namespace foreland::apps
