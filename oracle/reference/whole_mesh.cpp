#include "oracle/reference/whole_mesh.h"

#include "oracle/reference/mesh_builder.h"
#include "oracle/reference/object_mesh.h"

namespace foreland::oracle {

client::KeyframeMesh wholeMesh(const client::Replica& replica) {
  client::MeshPatch ends;
  replica.makeEmptyPatch(ends);
  client::KeyframeMesh mesh;
  mesh.from = ends.from, mesh.to = ends.to;
  mesh.earlier = ends.earlier;
  mesh.origin = ends.origin;
  MeshBuilder(replica.domain(), replica.nodes(), replica.morphs().all(), replica.heights(), mesh, replica.order())
      .run();
  for (const client::ObjectReplica& object : replica.objects()) {
    const client::ObjectPositions positions = object.positions(*replica.objectStream());
    buildObjectMesh(object.set(), positions,
                    {object.from(), object.to(), object.section(), object.morphs().all(), object.mesh().carried()})
        .appendTo(mesh, object.model());
  }
  return mesh;
}

}  // namespace foreland::oracle
