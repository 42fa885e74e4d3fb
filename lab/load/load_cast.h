// The viewers of a load: what each flies, asks for and is linked by. Pure; any thread.
#pragma once

#include <span>
#include <vector>

#include "base/rng.h"
#include "lab/load/light_viewer.h"
#include "lab/load/load_run.h"
#include "terrain/store/scene.h"

namespace foreland::lab {

struct LoadTours {
  explicit LoadTours(const terrain::Scene& scene);
  std::shared_ptr<const proto::Path> survey, canyon, spin, orbit;
};

struct LoadCast {
  LightViewer::Flight flight;
  proto::ViewRequest request;
  sim::LinkPair links;
  bool is_jumper = false;  // of the mix, whose motion nobody foresees
};

// The role with this number, of those that Mix lists.
LoadCast castOf(const LoadTours& tours, const LoadOptions& options, size_t role, Rng& chance);

// When a viewer comes, by its number: one after another within a second, or in a step (LoadOptions::before_step).
Time comesAt(size_t viewer, const LoadOptions& options);

// One of all viewers: when their keyframes are due follows from their
// clocks. The same in virtual and in real time.
struct LoadViewer {
  LoadCast cast;
  uint64_t link_seed;
  Time comes;
  Duration clock;  // the viewer's less the server's
};
// The viewers' roles in the order in which they come. Among servers that is any order, for otherwise taking turns would
// give all hogs to the same one.
std::vector<size_t> rolesOf(const LoadOptions& options, Rng& chance);
std::vector<LoadViewer> viewersOf(const LoadTours& tours, const LoadOptions& options, std::span<const size_t> roles);

}  // namespace foreland::lab
