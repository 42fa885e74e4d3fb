// A surface's file, through the real bounds and the real writer.
#pragma once

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "terrain/surface/bounds.h"
#include "terrain/surface/shapes.h"
#include "terrain/surface_store/write_surface.h"

namespace foreland::test {

// A cube about a point.
inline terrain::ConvexSolid cubeAbout(const glm::dvec3& middle, double half) {
  std::vector<terrain::SolidPlane> planes;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      glm::dvec3 normal(0);
      normal[axis] = sign;
      planes.push_back({normal, sign * middle[axis] - half});
    }
  return terrain::makeSolid(planes, 2 * (glm::length(middle) + half));
}

// A sphere of radius 2 about the origin: an octahedron halved three times.
inline void writeSphere(const std::string& path) {
  const terrain::TrueSurface sphere = *terrain::makeSphere(2, {proto::MeshRule::kQuadrisection, 3, 1e-3});
  const auto records = terrain::computeBounds(sphere, {.threads = 1});
  EXPECT_TRUE(terrain::writeSurface(path, {.surface = sphere, .records = records, .about = {"sphere", {}, {}}}).ok());
}

// The same, twice as large at the last time.
inline void writeGrowingSphere(const std::string& path, Time first, Time last) {
  terrain::TrueSurface sphere = *terrain::makeSphere(2, {proto::MeshRule::kQuadrisection, 3, 1e-3});
  terrain::SurfacePose large{sphere.base, sphere.nodes};
  for (glm::ivec3& quanta : large.base) quanta *= 2;
  for (glm::ivec3& quanta : large.nodes) quanta *= 2;
  sphere.poses.push_back(std::move(large));
  const auto records = terrain::computeBounds(sphere, {.threads = 1});
  EXPECT_TRUE(
      terrain::writeSurface(
          path, {.surface = sphere, .pose_times = {first, last}, .records = records, .about = {"sphere", {}, {}}})
          .ok());
}

}  // namespace foreland::test
