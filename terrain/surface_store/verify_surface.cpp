#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <string>

#include "proto/section/poses.h"
#include "terrain/store/check_slots.h"
#include "terrain/store/file/faults.h"
#include "terrain/surface/error_shape.h"
#include "terrain/surface_store/fill_gutters.h"
#include "terrain/surface_store/mapped_surface.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;

constexpr double kRounding = 1e-9;  // growthToHold is that much above the least growth

class SurfaceCheck {
 public:
  SurfaceCheck(const MappedSurface& surface, Faults& faults)
      : surface_(surface), topology_(surface.topology()), faults_(faults) {
    const SurfaceHeader& h = surface.header();
    low_ = {h.low[0], h.low[1], h.low[2]}, high_ = {h.high[0], h.high[1], h.high[2]};
  }

  bool isInBox(const glm::ivec3& p) const {
    return glm::all(glm::lessThanEqual(low_, p)) && glm::all(glm::lessThanEqual(p, high_));
  }
  // Whether the slot holds a node; otherwise it is padding.
  bool check(proto::Slot slot) const {
    const proto::SurfaceRecord& record = surface_.nodes()[slot];
    const NodeId n = topology_.node(slot);
    if (topology_.isBase(n)) {
      if (!isZero(record) || moves(slot, [](const glm::ivec3& move) { return move != glm::ivec3(0); }))
        fault(slot, "is padding but not zero");
      return false;
    }
    if (!isInBox(record.position)) fault(slot, "lies outside the surface's box");
    if (moves(slot, [&](const glm::ivec3& move) { return proto::moveWithin(record.position, move) != move; }))
      fault(slot, "moves too far");
    const auto bounds = proto::SurfaceBounds::of(record, surface_.quantumMetres());
    if (!std::isfinite(bounds.radius) || !std::isfinite(bounds.along) || !std::isfinite(bounds.across)) {
      fault(slot, "has a bound that is no number");
      return true;
    }
    for (NodeId child : topology_.children(n)) checkChild(slot, bounds, topology_.slot(child));
    return true;
  }

 private:
  template <class Is>
  bool moves(proto::Slot slot, const Is& is) const {
    const proto::ModelNodes nodes{surface_.nodes(), surface_.nodeMoves(), surface_.movesEach()};
    return std::ranges::any_of(nodes.movesOf(slot), is);
  }
  void fault(proto::Slot slot, const std::string& what) const {
    faults_.add(slot, "slot " + std::to_string(slot) + ' ' + what);
  }
  static bool isZero(const proto::SurfaceRecord& record) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(&record);
    return std::all_of(bytes, bytes + sizeof(record), [](uint8_t byte) { return byte == 0; });
  }
  void checkChild(proto::Slot slot, const proto::SurfaceBounds& bounds, proto::Slot child) const {
    const proto::SurfaceRecord& record = surface_.nodes()[child];
    const auto below = proto::SurfaceBounds::of(record, surface_.quantumMetres());
    const std::string whose = " of its child in slot " + std::to_string(child);
    if (glm::distance(bounds.position(), below.position()) + below.radius > bounds.radius)
      fault(slot, "has a sphere that does not hold that" + whose);
    const double cosine = glm::dot(bounds.normal(), below.normal());
    const double turn = std::atan2(glm::length(glm::cross(bounds.normal(), below.normal())), cosine);
    if (!surface_.nodes()[slot].cone_sine.isFull() &&
        (record.cone_sine.isFull() || turn + std::asin(below.sin_cone) > std::asin(bounds.sin_cone)))
      fault(slot, "has a cone of normals that does not hold that" + whose);
    if (growthToHold(surface_.errorShape(), {bounds.along, bounds.across}, bounds.normal(), {below.along, below.across},
                     below.normal()) > 1 + kRounding)
      fault(slot, "has an error shape that does not hold that" + whose);
  }

  const MappedSurface& surface_;
  const proto::MeshTopology& topology_;
  glm::ivec3 low_, high_;
  Faults& faults_;
};

// By the proof, from the positions in the file.
void checkSolids(const MappedSurface& surface, Faults& faults) {
  if (surface.innerSolids().solids.empty()) return;
  const TrueSurface whole = positionsOf(surface);
  for (size_t i = 0; i < surface.innerSolids().solids.size(); ++i)
    if (!isInside(surface.innerSolids().solids[i], whole))
      faults.add(surface.topology().slotCount(),
                 "inner solid " + std::to_string(i) + " is not inside of all that may be drawn of the surface");
}

}  // namespace

Result<VerifyReport> verifySurface(const std::filesystem::path& path, unsigned threads) {
  const auto surface = MappedSurface::open(path);
  if (!surface.ok()) return surface.error();
  return verifySurface(**surface, threads);
}

VerifyReport verifySurface(const MappedSurface& surface, unsigned threads) {
  Faults blocks, values;
  const SectionRange& checksums = surface.header().sections[kSurfaceChecksums];
  checkBlocks(surface.file(), checksums, threads, blocks);
  const SurfaceCheck check(surface, values);
  for (size_t v = 0; v < surface.basePositions().size(); ++v)
    if (!check.isInBox(surface.basePositions()[v]))
      values.add(0, "base vertex " + std::to_string(v) + " lies outside the surface's box");
  if (const auto seam = findSeam(surface.atlas(), surface.topology().base(), surface.texels(), threads))
    values.add(surface.topology().slotCount(), *seam);
  checkSolids(surface, values);
  VerifyReport report;
  report.blocks = blockCount(checksums);
  report.base_vertices = surface.basePositions().size();
  report.texels = surface.texels().size();
  report.nodes =
      checkSlots(surface.topology().slotCount(), threads, [&](proto::Slot slot) { return check.check(slot); });
  report.padding = surface.topology().slotCount() - report.nodes;
  report.faults = blocks.count() + values.count();
  report.first_faults = blocks.first();
  for (const std::string& fault : values.first()) report.first_faults.push_back(fault);
  return report;
}

}  // namespace foreland::terrain
