// The first step to an Original: one vertex for each position, and triangles for the faces of any number of corners.
// Pure; any thread.
#pragma once

#include "base/result.h"
#include "terrain/model/model.h"
#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

// Fills in positions, faces and where they came from. Errors, without the model's name, and repairs are those of
// makeOriginal that concern a single face.
[[nodiscard]] Status weldAndTriangulate(const Model& model, OnDefect on_defect, Original& made);

}  // namespace foreland::terrain
