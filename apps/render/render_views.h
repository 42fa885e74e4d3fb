// Where the pictures of `foreland render` are taken from. Pure functions; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/render/render_options.h"
#include "client/fly/tracks/track.h"
#include "proto/space/pose.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

struct Views {
  std::vector<proto::Pose> poses;
  std::vector<std::string> notes;  // on the track
};

// One pose, or one for each step of a track or tour. An Error names the option and what it may be: text that is no
// pose, a pose beyond the data or under the ground, a tour that there is not, a track that leads past.
Result<Views> viewsOf(const RenderOptions& options, const std::optional<client::Track>& track,
                      const terrain::Scene& scene);

}  // namespace foreland::apps
