// The triangles of a drawn mesh on the faces of a globe's cube. Pure; any thread.
#pragma once

#include <vector>

#include "client/mesh/patch/keyframe_mesh.h"
#include "oracle/globe/cube_faces.h"
#include "oracle/patchwork.h"

namespace foreland::oracle {

// A triangle whose corners are not on one face is left out: what it should cover is uncovered.
inline std::vector<FaceTriangle> trianglesOnFaces(const client::KeyframeMesh& mesh, const CubeFaces& cube) {
  std::vector<CubeFaces::Point> points;
  for (const glm::vec2& p : mesh.parameters)
    points.push_back(cube.pointOf(proto::NodeId::at(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y))));
  std::vector<FaceTriangle> triangles;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    FaceTriangle t{0, {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]}, {}};
    const auto face = CubeFaces::faceOf(points[t.vertex[0]], points[t.vertex[1]], points[t.vertex[2]], cube.side());
    if (!face) continue;
    t.face = *face;
    for (size_t k = 0; k < 3; ++k) t.place[k] = glm::dvec2(cube.placeOn(*face, points[t.vertex[k]]));
    triangles.push_back(t);
  }
  return triangles;
}

// An ellipsoid that no ground of a globe reaches into. A metre for rounding; it is flatter than a surface of constant
// height.
inline terrain::Ellipsoid lowestEllipsoid(const terrain::Scene& scene) {
  const proto::Frame& frame = scene.frame();
  const double depth_m = std::min(0, scene.heightRange().lowest) * frame.height_quantum_m - 1,
               polar_m = frame.semi_major_m * (1 - frame.flattening) + depth_m;
  terrain::Ellipsoid lowest;
  lowest.semi_major_m = frame.semi_major_m + depth_m;
  lowest.flattening = 1 - polar_m / lowest.semi_major_m;
  return lowest;
}

}  // namespace foreland::oracle
