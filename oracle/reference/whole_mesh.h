// The mesh that a replica shows, made from nothing: for tools that take one mesh, and as the reference of the mesh by
// change.
#pragma once

#include "client/mesh/patch/keyframe_mesh.h"
#include "client/replica.h"

namespace foreland::oracle {

// The mesh of the replica's last apply() or extend(). After the first keyframe it shows that keyframe's section at both
// ends. Its origin is within Replica::kOriginReach_m of the newer keyframe's eye. Pure; O(sections).
client::KeyframeMesh wholeMesh(const client::Replica& replica);

}  // namespace foreland::oracle
