// What `foreland bench surfaces` prints of one surface; bench/README.md names the keys.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "bench/surfaces/measure.h"

namespace foreland::bench {

nlohmann::ordered_json surfaceReport(const terrain::TrueSurface& surface, const SurfaceSession& session);

}  // namespace foreland::bench
