// What `foreland bench surfaces` prints of one surface; lab/README.md names the keys.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "lab/surfaces/measure.h"

namespace foreland::lab {

nlohmann::ordered_json surfaceReport(const terrain::TrueSurface& surface, const SurfaceSession& session);

}  // namespace foreland::lab
