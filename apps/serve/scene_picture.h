// The small pictures by which a server with several scenes shows them: their ground from above, north up, tinted by
// height and lit from the north-west, as maps are. Pure; any thread.
#pragma once

#include "server/net/http/png.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

// 320 to 640 pixels along the longer side, or fewer of a scene that has fewer samples: one for each sample of a coarse
// level, which lie together in the file. Of a globe, one face of its cube.
server::Picture scenePicture(const terrain::Scene& scene);

}  // namespace foreland::apps
