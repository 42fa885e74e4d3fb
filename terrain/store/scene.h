// A scene file opened for reading: the refinement hierarchy of one terrain, memory-mapped, immutable. All threads share
// it. Layout of every byte: docs/SCENE_FORMAT.md. Opening checks magic, version, sizes, header checksum and that the
// file is whole; block checksums are checked by verifyScene (verify.h), so opening costs the same for any size.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/section/bounds.h"
#include "proto/section/node_tables.h"
#include "proto/section/page_directory.h"
#include "proto/space/frame.h"
#include "proto/topology/grid.h"
#include "terrain/store/coded/coded_pages.h"
#include "terrain/store/distant/page_supply.h"
#include "terrain/store/tables/datum_section.h"
#include "terrain/store/tables/epoch_table.h"
#include "terrain/store/tables/tile_table.h"

namespace foreland::terrain {

using proto::NodeRecord;

// What the scene was made from. For people to read; no geometry depends on it.
struct SceneOrigin {
  std::string title;               // file names of the inputs
  std::string crs_wkt;             // empty if none
  std::vector<std::string> notes;  // how voids were filled, what was assumed
  uint64_t voids_filled = 0;
};

struct HeightRange {
  int32_t lowest = 0;
  int32_t highest = 0;
};

class Scene {
 public:
  // Of a scene whose pages are coded so many bytes of them are held inflated.
  static Result<std::shared_ptr<const Scene>> open(const std::filesystem::path& path,
                                                   uint64_t page_cache_bytes = kDefaultPageCacheBytes);
  virtual ~Scene() = default;

  const proto::GridTopology& grid() const { return grid_; }
  const proto::Frame& frame() const { return frame_; }
  const proto::SphereLevels& spheres() const { return spheres_; }
  // Identifies the content: two builds of the same input have the same id. Clients resume by it.
  uint64_t id() const { return id_; }
  HeightRange heightRange() const { return heights_; }  // over the data
  const SceneOrigin& origin() const { return origin_; }

  // What heights count from: as the scene states it, else as its reference system does.
  const proto::VerticalDatum& vertical() const { return datum_.vertical; }
  // Whether viewers draw the sea, at height 0 above the geoid, or above the ellipsoid where none is known; globes
  // alone.
  bool hasSea() const { return has_sea_; }
  // What the scene was put together from; empty where it does not state its datum.
  const std::vector<SceneInput>& inputs() const { return datum_.inputs; }

  // Whether some deep pages need not be there.
  bool isSparse() const { return grid_.shape().sparse_levels > 0; }
  // Which pages of nodes are there.
  const proto::PageDirectory& pages() const { return directory_; }
  // By place in the file; slots that are padding hold zeros. Where pages are coded, those that are read are inflated.
  std::span<const NodeRecord> records() const { return records_; }
  // By slot. A node whose page is not there reads as zeros.
  proto::StoredNodes nodes() const {
    return isSparse() ? proto::StoredNodes(records_, directory_) : proto::StoredNodes(records_);
  }
  const NodeRecord& node(proto::NodeId n) const { return nodes()[grid_.slot(n)]; }
  // Base vertices, row by row from the south: (roots_x + 1) * (roots_y + 1) corners; roots_x * roots_y centres.
  std::span<const int32_t> cornerHeights() const { return corners_; }
  std::span<const int32_t> centreHeights() const { return centres_; }

  // What is known of coded pages; null where pages are as they are in memory.
  const CodedPages* coded() const { return coded_.get(); }

  // Which pages and tiles are there, of a scene at a distance (distant_scene.h): whoever reads records() or the bytes
  // of tiles asks it before. Null where all are.
  const PageSupply* supply() const { return supply_.get(); }

  // How the ground moves in time. Errors and radii of nodes hold for all scene times, heights for the first.
  const EpochTable& epochs() const { return epochs_; }

  // Relief and imagery.
  const TileTable& tiles() const { return tiles_; }

  // The bytes of the objects, which terrain/objects reads; empty if there are none.
  ByteSpan objectSection() const { return objects_; }

  // Height of any lattice point, node or base vertex, in quanta. Where no page is, in the file or, of a scene at a
  // distance, here, the ground is the triangle of the finest nodes around that are there, and the height is its nearest
  // whole number of quanta there.
  int32_t height(proto::NodeId v) const;

 protected:
  Scene(proto::GridTopology grid, proto::Frame frame)
      : grid_(std::move(grid)), frame_(std::move(frame)), spheres_(grid_, frame_), directory_(grid_) {}
  // `blocks` must outlive the scene.
  Status adoptPages(std::span<const proto::PageBlock> blocks);

  proto::GridTopology grid_;
  proto::Frame frame_;
  proto::SphereLevels spheres_;
  uint64_t id_ = 0;
  HeightRange heights_;
  SceneOrigin origin_;
  SceneDatum datum_;
  bool has_sea_ = false;
  proto::PageDirectory directory_;
  std::unique_ptr<CodedPages> coded_;
  std::shared_ptr<const PageSupply> supply_;
  std::span<const NodeRecord> records_;
  std::span<const int32_t> corners_, centres_;
  ByteSpan objects_;
  EpochTable epochs_;
  TileTable tiles_;
};

}  // namespace foreland::terrain
