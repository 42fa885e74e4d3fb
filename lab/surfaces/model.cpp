#include "lab/surfaces/model.h"

#include "terrain/model/read_model.h"
#include "terrain/remesh/remesh.h"
#include "terrain/remesh/remeshed_surface.h"
#include "terrain/surface_store/mapped_surface.h"

namespace foreland::lab {

namespace {

using terrain::TrueSurface;

Result<TrueSurface> stored(const std::filesystem::path& path) {
  const auto file = terrain::MappedSurface::open(path);
  if (!file) return file.error();
  const terrain::MappedSurface& surface = **file;
  TrueSurface made{surface.topology(), surface.quantumMetres(), {}, {}};
  made.base.assign(surface.basePositions().begin(), surface.basePositions().end());
  made.nodes.reserve(surface.nodes().size());
  for (const proto::SurfaceRecord& node : surface.nodes()) made.nodes.push_back(node.position);
  return made;
}

}  // namespace

Result<TrueSurface> surfaceOfModel(const std::filesystem::path& path, uint32_t base_triangles, uint32_t halvings) {
  if (terrain::isSurfaceFile(path)) return stored(path);
  const auto model = terrain::readModel(path);
  if (!model) return model.error();
  const auto original = terrain::makeOriginal(*model, terrain::OnDefect::kRepair);
  if (!original) return original.error();
  const auto remeshed =
      terrain::remesh(*original, {.base_triangles = base_triangles, .levels = static_cast<int>(halvings)});
  if (!remeshed) return remeshed.error();
  return terrain::toSurface(*remeshed, proto::MeshRule::kQuadrisection, terrain::defaultQuantum(*remeshed));
}

}  // namespace foreland::lab
