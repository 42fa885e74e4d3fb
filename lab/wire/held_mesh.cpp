#include "lab/wire/held_mesh.h"

#include <cmath>

#include "lab/wire/wire_client.h"
#include "oracle/reference/whole_mesh.h"
#include "server/section/sender.h"

namespace foreland::lab {

namespace {

constexpr uint32_t kUnused = 0xffffffffu;

void takeMesh(const client::KeyframeMesh& mesh, double quantum_m, HeldMesh& out) {
  std::vector<uint32_t> vertices(mesh.parameters.size(), kUnused);  // base vertices beyond the data are of no triangle
  for (uint32_t index : mesh.indices) {
    if (vertices[index] == kUnused) {
      vertices[index] = static_cast<uint32_t>(out.scene.positions.size());
      const glm::vec4& p = mesh.to_positions[index];
      out.scene.positions.emplace_back(p.x, p.y, p.z);
      out.lattice.positions.emplace_back(mesh.parameters[index].x, mesh.parameters[index].y,
                                         std::round(static_cast<double>(p.w) / quantum_m));
    }
    out.lattice.indices.push_back(vertices[index]);
  }
  out.scene.indices = out.lattice.indices;
}

void takeNodes(const client::Replica& replica, HeldMesh& out) {
  const proto::GridTopology& grid = replica.grid();
  for (proto::Slot slot : replica.section().slots) {
    const proto::NodeId n = grid.node(slot);
    const auto [a, b] = grid.endpoints(n);
    const int32_t height = *replica.knownHeight(n), sum = *replica.knownHeight(a) + *replica.knownHeight(b);
    out.heights.push_back(height);
    out.displacements.push_back(height - (sum >> 1));
  }
}

}  // namespace

HeldMesh meshHeldFor(const server::Hierarchy& hierarchy, const proto::View& view) {
  server::SectionSender sender(hierarchy);
  server::SendScratch scratch;
  HeldMesh held;
  Bytes message;
  sender.send(view, Time{}, scratch, message);
  held.bytes = message.size();
  WireClient client(hierarchy);
  client.take(message);
  takeMesh(oracle::wholeMesh(client.replica()), hierarchy.scene().frame().height_quantum_m, held);
  takeNodes(client.replica(), held);
  return held;
}

}  // namespace foreland::lab
