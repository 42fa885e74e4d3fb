// Where the pictures of `foreland render` are taken from. Pure functions but for reading the track; any thread.
#pragma once

#include <vector>

#include "apps/render/render_options.h"
#include "proto/space/pose.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

// One pose, or one for each step of a track or tour. An Error names the option and what it may be: text that is no
// pose, a pose beyond the data or under the ground, a tour that there is not, a track that cannot be read or leads
// past.
Result<std::vector<proto::Pose>> posesOf(const RenderOptions& options, const terrain::Scene& scene);

}  // namespace foreland::apps
