// What all sessions of a server share: one immutable scene. Any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "base/result.h"
#include "proto/message/message.h"
#include "server/imagery/visible_ground.h"
#include "server/occlusion/viewer_occlusion.h"
#include "server/section/ground_motion.h"
#include "server/section/hierarchy.h"
#include "server/sight/sight_supply.h"
#include "server/view/tour_plans.h"

namespace foreland::server {

// How what is asked of what is seen is prepared, and what ridges of a globe hide.
struct SightSetup {
  SightSupply::Building building = SightSupply::Building::kByTheCaller;
  SightOptions options{};
};

struct World {
  // O(samples) for a scene with tiles.
  explicit World(std::shared_ptr<const terrain::Scene> scene, SceneObjects objects = {}, const SightSetup& sight = {});
  Hierarchy hierarchy;
  std::unique_ptr<const GroundMotion> motion;  // null unless the blend of its epochs is cubic
  // By which tiles are chosen; null if the scene has none, or its ground moves.
  std::shared_ptr<const SceneGround> ground;
  std::shared_ptr<const SceneOcclusion> occlusion;  // of the hierarchy; null: nothing is left out as hidden
  std::unique_ptr<SightSupply> sight;               // for who asks what is seen
  std::unique_ptr<TourPlans> tours;
};

// Whether viewers who ask for it are sent nothing of what is hidden: none; each as long as it pays
// (session/plan/occlusion_control.h); all, always.
enum class Occlusion : uint8_t { kOff, kAuto, kOn };
// "off", "auto", "on". Nothing for other names.
const char* name(Occlusion occlusion);
std::optional<Occlusion> occlusionNamed(std::string_view name);

// The scene with its objects and, unless it is off, what all viewers share to find out what is hidden; with kAuto only
// if that can be made (SceneOcclusion::create). O(samples).
Result<std::shared_ptr<const World>> openWorld(std::shared_ptr<const terrain::Scene> scene,
                                               Occlusion occlusion = Occlusion::kOff, const SightSetup& sight = {});

// The message that tells a client about a scene. The session fills in tolerance and keyframe interval.
proto::Welcome welcomeTo(const Hierarchy& hierarchy);

}  // namespace foreland::server
