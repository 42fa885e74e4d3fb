// The viewers of a load: what each flies, asks for and is linked by. Pure; any thread.
#pragma once

#include "base/rng.h"
#include "bench/load/light_viewer.h"
#include "bench/load/load_run.h"
#include "bench/world/link_models.h"
#include "terrain/store/scene.h"

namespace foreland::bench {

struct LoadTours {
  explicit LoadTours(const terrain::Scene& scene);
  std::shared_ptr<const proto::Path> survey, canyon, spin;
};

struct LoadCast {
  LightViewer::Flight flight;
  proto::ViewRequest request;
  LinkPair links = fixedLink(Duration::milliseconds(50));
};

// The role with this number, of those that Mix lists.
LoadCast castOf(const LoadTours& tours, const LoadOptions& options, size_t role, Rng& chance);

}  // namespace foreland::bench
