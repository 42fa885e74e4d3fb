// Which samples of the files that a globe was made of must lie on its ground, each within the residual that the scene
// states of its file: those where that file alone counts. It knows samples, the scene's pages and what it states of
// its inputs, nothing of how heights between samples are made; it shares no code with what lays files over each other
// (terrain/dem). Pure; any thread.
//
// Rather too few than too many: a file's edges, feathers and holes are left out by rectangles, and what files above it
// may reach by cones around all of their samples.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "proto/space/frame.h"
#include "terrain/store/scene.h"

namespace foreland::oracle {

// The samples of one raster, row by row.
struct SourceRaster {
  uint32_t input = 0;  // of the scene's
  uint32_t width = 0, height = 0;
  std::vector<glm::dvec2> degrees;  // longitude and latitude; not numbers where no place is known
  std::vector<double> metres;       // above the ellipsoid; not numbers where there is no sample
};

// Samples that lie close to each other.
struct SourceBlock {
  uint32_t input = 0;
  std::vector<proto::Geodetic> samples;
};

std::vector<SourceBlock> samplesAlone(const terrain::Scene& scene, const std::vector<SourceRaster>& rasters);

// The longest edge, in lattice steps, that a triangle of a globe's ground at full resolution may have at a place of a
// face.
double longestEdgeAt(const terrain::Scene& scene, uint32_t face, glm::dvec2 place);
// How many metres a lattice step is at most, on the ellipsoid.
double longestStep(const proto::Frame& frame);

}  // namespace foreland::oracle
