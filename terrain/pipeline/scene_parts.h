// What builders of whole and of sparse scenes share. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "terrain/elevation_source.h"
#include "terrain/imagery/imagery.h"
#include "terrain/picture_source.h"
#include "terrain/store/scene.h"
#include "terrain/store/tables/datum_section.h"

namespace foreland::terrain {

inline Error stopped() { return {ErrorCode::kIo, "stopped before the scene was complete; nothing was written"}; }

// Samples that stayed where they were differ by rounding alone; that comes to what others differ by.
inline SceneDatum datumOf(const proto::VerticalDatum& vertical, const std::vector<ElevationInput>& inputs,
                          double height_quantum_m) {
  SceneDatum datum{vertical, {}};
  for (const ElevationInput& input : inputs)
    datum.inputs.push_back({.name = input.name,
                            .vertical = input.vertical,
                            .window = input.window,
                            .may_have_voids = input.may_have_voids,
                            .residual_m = (input.is_on_lattice ? 0 : input.residual_m) + 0.5 * height_quantum_m,
                            .feather_m = input.feather_m});
  return datum;
}

inline void describePicture(const std::vector<std::string>& notes, const ImageryReport& report, SceneOrigin& origin) {
  for (const std::string& note : notes) origin.notes.push_back(note);
  if (report.covered < 1)
    origin.notes.push_back("pictures cover " + std::to_string(static_cast<int>(report.covered * 100)) +
                           " % of the scene; the rest fades from what is nearest to it");
}

}  // namespace foreland::terrain
