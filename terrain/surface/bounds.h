// The bounds of every node of a surface (S 3.3; THEORY section 3), exact over the full-resolution surface and
// saturated. With V(n) the vertices where the node's hat function is not zero:
//
//   radius   the sphere about the node holds the full-resolution triangles at V(n), where they truly are and moved by
//            any error of their vertex in V(n), and its children's spheres
//   cone     about the node's normal, holds the normals of all full-resolution triangles at V(n), and its children's cones
//   bulge    the planes of those triangles pass no farther from the node, and so do all planes that a child allows: with a
//            whole sphere of margin for each triangle (S 3.3.2), a support would seem to turn away later than it does
//   error    about the node's normal, holds the *parametric* error (drawn position minus true position, at the same
//            parameter) of every vertex of V(n) in every section that has neither this node nor a coarser one whose hat
//            reaches the vertex, and its children's shapes
//
// A section without the node need not be the coarser level everywhere around it: by quadrisection its neighbours may be
// there. S equation 2 takes the whole finer surface away, which says less. What is missing at a vertex is the sum of
// the missing nodes' displacements times their hats; any of the finer ones may be missing, so the shape contains the
// sum of those that point outward, that of those that point inward, and that of the parts across. Where all point the
// same way, as on the sphere, this is equation 2. By bisection the triangle that is drawn instead has true corners, and
// equation 2 is exact.
//
// A surface with several poses is never at rest, so that what its triangles' normals are is not followed: cones are
// full and planes pass anywhere. A sphere is about the node in the first pose and holds the support in all of them; an
// error shape holds the errors in each pose. Between poses, positions and errors are means of theirs, which these hold,
// too.
//
// So every vertex's error is held by the shape of some missing node whose support holds the vertex. A point of a
// triangle is off by a mean of the errors of its three vertices; three missing nodes hold those, and their spheres the
// triangle, so what the screen tests (proto/refine/surface/surface_metric.h) say of each error at that point holds for
// the mean: texels are as safe as vertices. All of it nests from child to parent, so the tests are monotone.
#pragma once

#include <functional>
#include <vector>

#include "proto/section/surface_bounds.h"
#include "terrain/surface/error_shape.h"
#include "terrain/surface/surface.h"

namespace foreland::terrain {

// How the axes of error shapes are chosen: see boundingShape and boundingShapeByLargest.
enum class ErrorFit : uint8_t { kSmallest, kByLargest };

struct SurfaceBoundsJob {
  ErrorShape shape = ErrorShape::kSpheroid;
  ErrorFit fit = ErrorFit::kSmallest;
  unsigned threads = 0;  // 0: one per processor; the result does not depend on it
  // Called on the calling thread with the fraction done. False stops the work.
  std::function<bool(double)> onProgress = [](double) { return true; };
};

// Records by slot, zeros in the padding; empty if `onProgress` stopped the work. Cost: about 0.5 microseconds times
// vertices times levels.
std::vector<proto::SurfaceRecord> computeBounds(const TrueSurface& surface, const SurfaceBoundsJob& job = {});

}  // namespace foreland::terrain
