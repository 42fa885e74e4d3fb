// The truth oracle of scenes that are fine in places only (sparse levels): judges every vertex that is there, as
// oracle.h does. It knows pages, records and the frame, nothing of how heights between vertices are found.
#pragma once

#include <memory>

#include "oracle/patchwork.h"

namespace foreland::oracle {

// Of a scene that is no globe.
Patchwork sparseOracle(std::shared_ptr<const terrain::Scene> scene);

}  // namespace foreland::oracle
