// Heights of a scene at any place, by both surfaces, with the input that they come from. Pure; any thread.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <string>

#include "base/time.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

struct SceneHeight {
  double height_m;  // above the scene's zero surface
  std::optional<proto::BothHeights> both;
  std::string source;  // the input, or all that it may be; of scenes that do not know, the scene's title
  std::optional<double> residual_m;
};

// Exact between samples as the scene has them, bilinear; of the ground at a time, in scenes that change. Nothing beyond
// the data.
std::optional<SceneHeight> heightAt(const terrain::Scene& scene, glm::dvec2 lattice, Time scene_time);

}  // namespace foreland::apps
