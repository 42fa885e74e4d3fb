#include "lab/wire/peer_report.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <string>

#include "lab/wire/held_mesh.h"
#include "lab/wire/peers/draco_peer.h"
#include "lab/wire/peers/entropy.h"
#include "lab/wire/peers/match.h"
#include "lab/wire/peers/meshoptimizer_peer.h"
#include "lab/wire/peers/quantized_mesh.h"

namespace foreland::lab {

namespace {

using nlohmann::ordered_json;

enum Peer : uint8_t { kQuantizedMesh, kMeshoptimizer, kMeshoptimizerExact, kDraco, kDracoExact };
constexpr std::array<const char*, 5> kPeerNames = {"quantized_mesh_gzip", "meshoptimizer_zstd",
                                                   "meshoptimizer_exact_zstd", "draco_qp14", "draco_exact"};

struct PeerTally {
  size_t bytes = 0;
  double max_error_m = 0;
};

// Sums over the meshes of one kind.
struct Tally {
  size_t meshes = 0, nodes = 0, vertices = 0, triangles = 0, own_bytes = 0;
  double height_entropy_bits = 0, displacement_entropy_bits = 0;
  std::array<PeerTally, kPeerNames.size()> peers;
};

class Comparison {
 public:
  Comparison(const server::Hierarchy& hierarchy, const PeerOptions& options)
      : hierarchy_(hierarchy), transform_(hierarchy.scene().frame()), options_(options) {}

  Status add(const proto::View& view, Tally& tally) {
    const HeldMesh held = meshHeldFor(hierarchy_, view);
    const double nodes = static_cast<double>(held.heights.size());
    ++tally.meshes;
    tally.nodes += held.heights.size();
    tally.vertices += held.scene.positions.size();
    tally.triangles += held.scene.indices.size() / 3;
    tally.own_bytes += held.bytes;
    tally.height_entropy_bits += nodes * orderZeroEntropyBits(held.heights);
    tally.displacement_entropy_bits += nodes * orderZeroEntropyBits(held.displacements);
    for (Peer peer : {kQuantizedMesh, kMeshoptimizer, kMeshoptimizerExact, kDraco, kDracoExact})
      if (Status s = run(peer, held, tally.peers[peer]); !s.ok()) return s;
    return {};
  }

  ordered_json report(const Tally& tally) const {
    const double meshes = static_cast<double>(tally.meshes), nodes = static_cast<double>(tally.nodes);
    const auto mean = [&](size_t sum) { return static_cast<double>(sum) / meshes; };
    const auto entry = [&](size_t bytes) {
      return ordered_json{{"bytes", mean(bytes)},
                          {"bits_per_vertex", 8.0 * static_cast<double>(bytes) / static_cast<double>(tally.vertices)}};
    };
    ordered_json out{{"meshes", tally.meshes},
                     {"nodes", mean(tally.nodes)},
                     {"vertices", mean(tally.vertices)},
                     {"triangles", mean(tally.triangles)},
                     {"foreland", entry(tally.own_bytes)}};
    out["foreland"]["bits_per_node"] = 8.0 * static_cast<double>(tally.own_bytes) / nodes;
    for (size_t i = 0; i < kPeerNames.size(); ++i) {
      if (i == kQuantizedMesh && !skipped_.empty()) {
        out[kPeerNames[i]] = nullptr;
        continue;
      }
      out[kPeerNames[i]] = entry(tally.peers[i].bytes);
      out[kPeerNames[i]]["max_error_m"] = tally.peers[i].max_error_m;
    }
    out["foreland_over_draco_exact"] =
        static_cast<double>(tally.own_bytes) / static_cast<double>(tally.peers[kDracoExact].bytes);
    out["height_entropy_bits_per_node"] = tally.height_entropy_bits / nodes;
    out["displacement_entropy_bits_per_node"] = tally.displacement_entropy_bits / nodes;
    return out;
  }

  const std::string& skipped() const { return skipped_; }

 private:
  static bool isOnLattice(Peer peer) {
    return peer == kQuantizedMesh || peer == kMeshoptimizerExact || peer == kDracoExact;
  }

  Result<PeerCode> code(Peer peer, const PeerMesh& mesh) const {
    switch (peer) {
      case kQuantizedMesh:
        return codeQuantizedMesh(mesh, options_.quantized_mesh);
      case kMeshoptimizer:
        return codeMeshoptimizer(mesh);
      case kMeshoptimizerExact:
        return codeMeshoptimizerExactly(mesh);
      case kDraco:
        return codeDraco(mesh);
      default:
        return codeDracoExactly(mesh);
    }
  }

  Status run(Peer peer, const HeldMesh& held, PeerTally& tally) {
    if (peer == kQuantizedMesh && !skipped_.empty()) return {};
    const PeerMesh& mesh = isOnLattice(peer) ? held.lattice : held.scene;
    const auto coded = code(peer, mesh);
    if (!coded && coded.error().code == ErrorCode::kNotFound) {
      skipped_ = coded.error().message;
      return {};
    }
    if (!coded) return coded.error();
    const auto match = matchMeshes(mesh, *coded);
    if (!match) return Error{match.error().code, std::string(kPeerNames[peer]) + ": " + match.error().message};
    tally.bytes += coded->bytes.size();
    for (size_t i = 0; i < match->size(); ++i)
      tally.max_error_m = std::max(tally.max_error_m, glm::distance(inMetres(peer, coded->decoded.positions[i]),
                                                                    inMetres(peer, mesh.positions[(*match)[i]])));
    return {};
  }

  glm::dvec3 inMetres(Peer peer, const glm::dvec3& p) const {
    if (!isOnLattice(peer)) return p;
    return transform_.toScene(
        proto::LatticePosition{.x = p.x, .y = p.y, .height_m = p.z * transform_.frame().height_quantum_m});
  }

  const server::Hierarchy& hierarchy_;
  proto::FrameTransform transform_;
  PeerOptions options_;
  std::string skipped_;  // why quantized-mesh is; empty if it is not
};

}  // namespace

std::filesystem::path peerSources() { return quantizedMeshSources(); }

Result<ordered_json> peersReport(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                                 const PeerOptions& options) {
  Comparison comparison(hierarchy, options);
  Tally first, half, flight;
  proto::View finer = views.front();
  finer.tau_px *= 0.5;
  if (Status s = comparison.add(views.front(), first); !s.ok()) return s.error();
  if (Status s = comparison.add(finer, half); !s.ok()) return s.error();
  const size_t samples = std::min<size_t>(options.samples, views.size() - 1);
  for (size_t i = 1; i <= samples; ++i)
    if (Status s = comparison.add(views[i * (views.size() - 1) / samples], flight); !s.ok()) return s.error();
  ordered_json report{{"meshoptimizer", meshoptimizerVersion()}, {"draco", dracoVersion()}};
  if (!comparison.skipped().empty()) report["quantized_mesh_skipped"] = comparison.skipped();
  report["first_section"] = comparison.report(first);
  report["first_section_half_tau"] = comparison.report(half);
  if (samples > 0) report["in_flight"] = comparison.report(flight);
  return report;
}

}  // namespace foreland::lab
