// `foreland serve A.fls B.fls`: several scenes by one server, each at a path of its own, and the page that lists them.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

struct GalleryScene {
  std::string name;  // in paths
  std::shared_ptr<const terrain::Scene> scene;
};

// Files by their names in paths, without `.fls`: an Error if one will not do, two are the same, or one file is named
// twice.
Result<std::vector<std::string>> galleryNames(const std::vector<std::filesystem::path>& files);
// An Error if two are one scene, by their ids.
Status checkDifferent(const std::vector<GalleryScene>& scenes);

// The page at `/`, and a picture of each scene: by paths in URLs.
std::map<std::string, std::string> galleryFiles(const std::vector<GalleryScene>& scenes);

}  // namespace foreland::apps
