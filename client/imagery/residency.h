// Which tiles of a layer stand on the graphics card, in which layer of a texture array, and how they fade. It is
// decided once for each mesh, from what the mesh's newer keyframe sees and what will presumably be seen soon:
//   - tiles that come fade in with the mesh's weight from their parent's image, those that go fade out to it; a tile
//     comes only if its parent was there before, and goes only if none of its children is drawn. So the beginning of a
//     mesh shows exactly what the end of the one before showed
//   - there are never more tiles than texture layers; where more are wanted those with the smallest texels on the screen
//     are left out
//   - the layer of a tile that goes is not written before the mesh after the next one, so uploads can run ahead
// Tiles that are not selected stay as long as there is room. One owner. Source: THEORY section 5, "In the client".
#pragma once

#include <optional>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "proto/imagery/tile.h"
#include "proto/imagery/tile_selection.h"

namespace foreland::client {

class Residency {
 public:
  // The page table has so many pages along each side of each level; page (x, y) is at (x, y) modulo this. On a globe
  // pages of face f count from the face's first one, and lie half a side further east if f modulo 3 is 1, and north if
  // it is 2; where a face has at most eight pages a side, those of faces 3 to 5 as much further east.
  static constexpr uint32_t kPageSide = 32;
  static constexpr uint32_t kMaxArrivals = 16;  // tiles that come with one mesh

  enum class Fade : uint8_t { kNone = 0, kComing = 1, kGoing = 2 };
  struct Shown {
    proto::TileId tile;
    uint32_t texture_layer;
    Fade fade;
  };
  // A tile to be uploaded before the mesh is shown. `parent_layer` is the texture layer of its parent, if it has one.
  struct Arrival {
    proto::TileId tile;
    uint32_t texture_layer;
    std::optional<uint32_t> parent_layer;
  };

  Residency(const proto::TileLayer& layer, uint8_t index, uint32_t texture_layers);

  // Decides for the next mesh, which a keyframe of view `to` ends; `expected` is the view two keyframes later, for a
  // tile is decoded with one mesh and fades in with the next. `held` knows the tiles that can be decoded. O(tiles
  // selected + texture layers).
  void advance(const proto::FrameTransform& frame, const proto::View& to, const proto::View& expected,
               const proto::TileLookup& held);

  // A tile that should be decoded next, the most urgent first, each once; nullopt if there is none.
  std::optional<proto::TileId> takeWanted();
  // It has been decoded, and may come with the next mesh.
  void setReady(const proto::TileId& tile);

  // Of the last advance(); valid until the next one.
  const std::vector<Shown>& shown() const { return shown_; }
  // The largest size on the screen, in pixels, of texels that the mesh shows of what `to` sees in place of finer ones
  // that are held: while these are decoded or fade in, or where there is no room for them. 0 if there are none.
  float texelPx() const { return texel_px_; }
  const std::vector<Arrival>& arrivals() const { return arrivals_; }
  // Tiles of takeWanted() whose content is of no use any more.
  const std::vector<proto::TileId>& dropped() const { return dropped_; }
  // For each level, from the finest, and each row of its pages: four numbers a page. x / kPageSide and y / kPageSide of
  // the tile that is drawn there, its texture layer + 1 (0: none), and its Fade.
  const std::vector<uint16_t>& pageTable() const { return page_table_; }

 private:
  struct Resident {
    proto::TileId tile;
    proto::TileBounds bounds;
    uint32_t came = 0;      // number of the mesh with which it came; 0: the layer is free
    uint32_t went = 0;      // and went; 0: it is drawn
    uint32_t selected = 0;  // number of the last mesh that selected it
  };
  Resident* find(const proto::TileId& tile);
  bool isDrawnThroughout(const proto::TileId& tile);
  bool isDrawn(const Resident& r) const { return r.came > 0 && (r.went == 0 || r.went == mesh_); }
  bool hasDrawnChild(const proto::TileId& tile);
  bool canCome(const proto::TileId& tile);
  size_t pageOf(const proto::TileId& tile) const;
  void select(const proto::FrameTransform& frame, const proto::View& to, const proto::View& expected,
              const proto::TileLookup& held);
  void keepLargest(size_t most);
  void forgetUnselected();
  void admit();
  void addIfReady(const proto::TileId& tile);
  std::optional<uint32_t> takeLayer();
  void makeRoom();
  void write();
  void measure();

  proto::TileLayer layer_;
  uint8_t index_;
  uint32_t mesh_ = 0;
  std::vector<Resident> residents_;                         // by texture layer
  std::unordered_map<uint64_t, uint32_t> places_;           // texture layers by tile
  std::vector<proto::SelectedTile> seen_, expected_;        // by `to` and `expected`
  std::vector<proto::SelectedTile> selected_;               // of both, what there is room for
  std::unordered_map<uint64_t, proto::TileBounds> bounds_;  // of what is selected
  std::unordered_set<uint64_t> taken_, ready_;              // by takeWanted(), setReady()
  std::unordered_map<size_t, uint32_t> pages_;              // texture layers that are drawn, by their page
  std::vector<uint32_t> in_the_way_;                        // texture layers whose page another tile needs
  std::vector<Shown> shown_;
  std::vector<Arrival> arrivals_;
  std::vector<proto::TileId> dropped_;
  std::vector<uint16_t> page_table_;
  float texel_px_ = 0;
};

}  // namespace foreland::client
