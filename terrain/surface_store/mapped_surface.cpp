#include "terrain/surface_store/mapped_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include "proto/section/poses.h"
#include "terrain/store/format.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kMaxFaces = proto::BaseMesh::kMaxFaces;

Status malformed(const char* what) { return Error{ErrorCode::kMalformed, what}; }

// Checks what depends on the header alone, and bounds every number that sizes are computed from.
Status checkNumbers(const SurfaceHeader& h) {
  if (h.rule > static_cast<uint32_t>(proto::MeshRule::kBisection))
    return malformed("its rule of refinement is unknown");
  if (h.base_faces == 0 || h.base_faces > kMaxFaces || h.base_vertices > proto::BaseMesh::kMaxVertices)
    return malformed("its base mesh has too many or no faces");
  if (h.error_shape > static_cast<uint32_t>(proto::ErrorShape::kHoppe)) return malformed("its error shape is unknown");
  const bool is_posed = h.poses > 0, may_be_posed = h.version >= SurfaceHeader::kPosesVersion,
             must_be_posed = h.version == SurfaceHeader::kPosesVersion;
  if (h.poses == 1 || h.poses > proto::kMaxPoses || (is_posed && !may_be_posed) || (must_be_posed && !is_posed))
    return malformed("its number of poses is impossible");
  const bool has_solids = h.version == kSurfaceVersion;
  bool has_origin = false;
  for (const double coordinate : h.origin) {
    if (!(std::fabs(coordinate) <= kMaxSurfaceOrigin)) return malformed("its origin is impossible");
    has_origin |= coordinate != 0;
  }
  if (!has_solids && has_origin != (h.version == SurfaceHeader::kOriginVersion))
    return malformed("its origin is impossible");
  if (has_solids != (h.solids > 0)) return malformed("its inner solids are impossible");
  if (!(h.quantum_m > 0) || !std::isfinite(h.quantum_m)) return malformed("its step is no positive number");
  for (int axis = 0; axis < 3; ++axis)
    if (h.low[axis] > h.high[axis]) return malformed("its box is empty");
  if (h.atlas_side > proto::AtlasLayout::kMaxPixels || h.atlas_columns > proto::AtlasLayout::kMaxPixels ||
      h.atlas_side % proto::AtlasLayout::kUnit != 0 || (h.atlas_side == 0) != (h.atlas_columns == 0))
    return malformed("its image has an impossible size");
  const proto::AtlasLayout atlas{h.base_faces, h.atlas_side, h.atlas_columns};
  if (atlas.width() > proto::AtlasLayout::kMaxPixels || atlas.height() > proto::AtlasLayout::kMaxPixels)
    return malformed("its image has an impossible size");
  return {};
}

// Checks that the sections lie where the header's numbers put them.
Status checkPlaces(const SurfaceHeader& header) {
  const uint64_t text_bytes = header.sections[kSurfaceText].bytes;
  if (text_bytes > kMaxTextBytes) return malformed("its text is too long");
  SurfaceHeader expected = header;
  if (placeSurface(expected, text_bytes) != header.file_bytes ||
      !std::equal(std::begin(expected.sections), std::end(expected.sections), std::begin(header.sections)))
    return malformed("its sections are not where they belong");
  return {};
}

}  // namespace

Status MappedSurface::readPoseTimes() {
  const ByteSpan vertices = section<uint8_t>(kSurfaceVertices);
  const size_t begin = vertices.size() - sizeof(int64_t) * header_.poses;
  for (uint32_t pose = 0; pose < header_.poses; ++pose) {
    Time time;
    std::memcpy(&time.us, vertices.data() + begin + sizeof(time.us) * pose, sizeof(time.us));
    const bool is_absurd = time.us < -proto::Epochs::kMaxTime_us || time.us > proto::Epochs::kMaxTime_us;
    if (is_absurd || (pose > 0 && time <= pose_times_.back()))
      return malformed("the dates of its poses are out of order");
    pose_times_.push_back(time);
  }
  return {};
}

TrueSurface positionsOf(const MappedSurface& surface) {
  TrueSurface whole{surface.topology(), surface.quantumMetres(), {}, {}};
  whole.base.assign(surface.basePositions().begin(), surface.basePositions().end());
  whole.nodes.reserve(surface.nodes().size());
  for (const proto::SurfaceRecord& record : surface.nodes()) whole.nodes.push_back(record.position);
  for (size_t pose = 0; pose < surface.movesEach(); ++pose) {
    SurfacePose& moved = whole.poses.emplace_back(SurfacePose{whole.base, whole.nodes});
    const size_t each = surface.movesEach();
    for (size_t v = 0; v < moved.base.size(); ++v)
      moved.base[v] += proto::moveWithin(moved.base[v], surface.baseMoves()[v * each + pose]);
    for (size_t n = 0; n < moved.nodes.size(); ++n)
      moved.nodes[n] += proto::moveWithin(moved.nodes[n], surface.nodeMoves()[n * each + pose]);
  }
  return whole;
}

bool isSurfaceFile(const std::filesystem::path& path) {
  std::array<char, 8> magic{};
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed)) return false;
  return std::ifstream(path, std::ios::binary).read(magic.data(), magic.size()) && magic == kSurfaceMagic;
}

Result<std::shared_ptr<const MappedSurface>> MappedSurface::open(const std::filesystem::path& path) {
  return openMapped<MappedSurface>(path);
}

Result<std::shared_ptr<const MappedSurface>> MappedSurface::of(ByteSpan bytes, const std::string& path,
                                                               std::shared_ptr<const void> owner) {
  if (bytes.size() < kPageBytes) return damagedFile(path, "it is cut short");
  const auto header = readHeader<SurfaceHeader>(bytes, path);
  if (!header.ok()) return header.error();
  for (const auto check : {checkNumbers, checkPlaces})
    if (const Status status = check(*header); !status.ok()) return damagedFile(path, status.error().message);

  const auto faces = sectionOf<proto::BaseFace>(bytes, header->sections[kSurfaceFaces]);
  auto topology = proto::MeshTopology::create({static_cast<proto::MeshRule>(header->rule),
                                               header->halvings,
                                               header->base_vertices,
                                               {faces.begin(), faces.end()}});
  if (!topology.ok()) return damagedFile(path, topology.error().message);
  if (topology->slotCount() != header->slot_count) return damagedFile(path, "its sizes contradict each other");
  auto solids = solidsOf(*header);
  if (!solids.ok()) return damagedFile(path, solids.error().message);
  if (header->solids > 0 && !(topology->base().isClosed() && header->poses == 0))
    return damagedFile(path, "it has inner solids, but a border or poses");
  std::shared_ptr<MappedSurface> surface(
      new MappedSurface(bytes, std::move(owner), *header, std::move(topology).value()));
  surface->inner_solids_ = std::move(*solids);
  if (const Status times = surface->readPoseTimes(); !times.ok()) return damagedFile(path, times.error().message);
  if (contentId(*header, surface->section<uint8_t>(kSurfaceChecksums)) != header->scene_id)
    return damagedFile(path, "its table of checksums is damaged");
  if (Status text = decodeText(surface->section<uint8_t>(kSurfaceText), surface->about_); !text.ok())
    return damagedFile(path, text.error().message);
  return std::shared_ptr<const MappedSurface>(std::move(surface));
}

}  // namespace foreland::terrain
