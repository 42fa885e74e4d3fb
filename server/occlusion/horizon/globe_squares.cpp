#include "server/occlusion/horizon/globe_squares.h"

#include "base/check.h"

namespace foreland::server {

namespace {

constexpr double kErrorPad_m = 1e-6;  // what errors leave out, many times over

}  // namespace

GlobeSquares::GlobeSquares(const Hierarchy& hierarchy)
    : hierarchy_(hierarchy), nodes_(hierarchy.table()), face_log2_(hierarchy.grid().shape().root_log2) {
  CHECK_TRUE(hierarchy.grid().isCube());
}

std::optional<GlobeSquares::Hull> GlobeSquares::hullOf(uint32_t scale, uint32_t i, uint32_t j) const {
  const proto::GridTopology& grid = hierarchy_.grid();
  for (; scale + 1 < face_log2_; ++scale, i /= 2, j /= 2) {
    const uint32_t s = 1u << scale, x = 2 * s * i, y = 2 * s * j, face = x >> face_log2_;
    if (face >= proto::Cube::kFaces || y >> face_log2_ != 0) return std::nullopt;
    const proto::Slot centre = grid.slot(proto::NodeId::at(x + s, y + s), grid.levelOfScale(scale));
    if (!nodes_.hasPage(centre)) continue;
    Hull hull{{}, nodes_.at(centre).error().metres() + kErrorPad_m};
    for (uint32_t corner = 0; corner < 4; ++corner) {
      const auto at = [&](uint32_t from, uint32_t bit) {
        return static_cast<int32_t>(from + 2 * s * (corner >> bit & 1));
      };
      const proto::NodeId v = grid.cube().name({face, at(x - (face << face_log2_), 0), at(y, 1)});
      hull.corners[corner] = hierarchy_.frame().position(v, nodes_.height(v));
    }
    return hull;
  }
  return std::nullopt;
}

bool GlobeSquares::isAtSeam(const proto::BlockId& block) const {
  const uint32_t side_log2 = block.scale + proto::BlockId::kSideLog2;
  if (side_log2 + 1 > face_log2_) return true;
  const uint32_t blocks = 1u << (face_log2_ - side_log2), x = block.x % blocks;  // along a face's side
  return x == 0 || x + 1 == blocks || block.y == 0 || block.y + 1 >= blocks;
}

}  // namespace foreland::server
