// The truth oracle of globes: judges what is drawn of one at every vertex of the scene, as oracle.h does. Where
// vertices are comes from vectors, angles and GeographicLib (cube_faces.h), their heights from the scene; it shares no
// code with the engine's topology, positions and horizon.
//
// Of what lies behind the body, by the ellipsoid that no ground reaches into, only errors within the tolerance are
// looked at: nobody sees it.
#pragma once

#include <memory>

#include "oracle/patchwork.h"

namespace foreland::oracle {

Patchwork globeOracle(std::shared_ptr<const terrain::Scene> scene);

}  // namespace foreland::oracle
