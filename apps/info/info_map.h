// A picture of a scene from above, with outlines of what it was put together from. Pure but for the file; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/model/image.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

struct Outline {
  std::string name;
  proto::LatticeWindow window;
  std::array<uint8_t, 3> colour;  // sRGB
  std::string about;              // resolution and residual, for people
};

// Of the inputs that the scene knows of, then of the windows of its epochs.
std::vector<Outline> outlinesOf(const terrain::Scene& scene);

// North up, its longer side 1024 pixels or as many as there are samples; pixels are as wide as high on the ground.
[[nodiscard]] Result<terrain::Image> drawMap(const std::shared_ptr<const terrain::Scene>& scene,
                                             const std::vector<Outline>& outlines);

// Writes it as PNG; the file appears whole or not at all.
Status writeMap(const std::shared_ptr<const terrain::Scene>& scene, const std::vector<Outline>& outlines,
                const std::filesystem::path& output);

void printOutlines(const std::vector<Outline>& outlines);
nlohmann::ordered_json describeOutlines(const std::vector<Outline>& outlines);

}  // namespace foreland::apps
