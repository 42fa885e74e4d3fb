// Looks for cracks in what is drawn of one object, by the parameters of its vertices alone; shares no code with what
// builds meshes. Sound means:
//   every vertex is a point of the surface's parameter domain, and the corners of a triangle are of one base face
//   vertices at one point are at one position, in both keyframes, also where base faces meet
//   every edge is shared by exactly two triangles with opposite directions, or lies on the border of the surface
//   every triangle has positive area in the parameter domain, and the areas of a base face's add up to the whole face
// Pure; any thread. O(n log n).
#pragma once

#include "oracle/crack_checker.h"
#include "oracle/surface/objects_oracle.h"

namespace foreland::oracle {

CrackReport findObjectCracks(const client::BlendMesh& mesh, const client::ObjectPart& part, const ModelTruth& model);

}  // namespace foreland::oracle
