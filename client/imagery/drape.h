// What is laid over the terrain in a scene: for relief and for imagery which tiles are drawn (residency.h), and
// relief's slopes, heights and shadows. For a host that draws; images are decoded by the host. One owner; `store`
// outlives it.
#pragma once

#include <array>
#include <optional>
#include <unordered_map>
#include <vector>

#include "client/imagery/residency.h"
#include "client/imagery/shadows.h"
#include "client/imagery/tile_store.h"
#include "proto/message/compact.h"
#include "proto/space/frame.h"

namespace foreland::client {

class Drape {
 public:
  // Layers of the texture arrays; a view may need up to 200 tiles of imagery.
  struct Sizes {
    uint32_t relief = 64, imagery = 256;
    uint32_t of(proto::TileContent content) const { return content == proto::TileContent::kRelief ? relief : imagery; }
  };

  static constexpr size_t kMaxRelit = 16;  // tiles with one mesh

  // For the scene that `store` is in.
  Drape(const TileStore& store, const Sizes& sizes);
  // Before the first advance(), for ground().
  void setHeights(const proto::FrameTransform& frame, double lowest_m, double highest_m);

  // Towards the sun that casts shadows, a unit vector of the scene frame; nothing: no shadows. Tiles that are drawn are
  // relit with the next meshes, some with each.
  void setSun(const std::optional<glm::dvec3>& sun);

  // Decides what is drawn with the next mesh, between these keyframes: the newest one, and the one before.
  void advance(const proto::FrameTransform& frame, const proto::KeyframeHeader& from, const proto::KeyframeHeader& to);
  // No texel of a content that frames of this mesh show is larger on the screen, in pixels, where there are finer ones:
  // of what the viewer lacks the server states it, of the rest the client knows. Holds within the region of `to`.
  // Infinity if nothing is guaranteed, or the scene has no such layer.
  double texelPx(proto::TileContent content) const { return texel_px_[static_cast<size_t>(content)]; }
  // nullptr if the scene has no such layer.
  const Residency* residency(proto::TileContent content) const;

  // Decodes a tile of relief that is wanted; false if none is. About 6 ms as WebAssembly.
  bool decodeRelief();
  // Tiles of relief that could not be decoded. They count as missing: their parents stay in their place.
  uint32_t damaged() const { return damaged_; }
  // Of a tile of relief that arrives with the last advance(): its slopes (slopes.h), and those of its half-size image.
  const std::vector<uint32_t>& slopes(const proto::TileId& tile) const { return relief_.at(tile.key()).slopes; }
  const std::vector<uint32_t>& halfSlopes(const proto::TileId& tile);
  // Likewise its ground texels (shadows.h), with the shadows of the present sun.
  const std::vector<uint32_t>& ground(const proto::TileId& tile);
  const std::vector<uint32_t>& halfGround(const proto::TileId& tile);
  // Tiles that are drawn and whose ground texels have changed with the sun, the coarser ones first.
  const std::vector<Residency::Shown>& relit() const { return relit_; }

  // An image to be decoded by the host, and then told of; nullopt if none is wanted.
  std::optional<proto::TileId> takeWantedImage();
  void setImageReady(const proto::TileId& tile);

 private:
  struct Relief {
    std::vector<uint32_t> slopes, ground;
    uint32_t cast = 0;    // number of the sun whose shadows `ground` has
    uint32_t handed = 0;  // and of those that the host has
  };
  void measure(uint32_t keyframe);
  void relight();
  Relief& litRelief(const proto::TileId& tile);
  std::optional<Residency>& at(proto::TileContent content) { return residencies_[static_cast<size_t>(content)]; }

  const TileStore& store_;
  std::array<std::optional<Residency>, proto::kMaxTileLayers> residencies_;  // by content
  std::array<double, proto::kMaxTileLayers> texel_px_{};                     // by content
  std::unordered_map<uint64_t, Relief> relief_;
  std::vector<uint32_t> half_;
  std::vector<Residency::Shown> relit_;
  std::optional<proto::FrameTransform> frame_;
  HeightCode code_;
  std::optional<glm::dvec3> sun_;
  uint32_t suns_ = 1;  // counts
  std::vector<int32_t> steps_;
  uint32_t damaged_ = 0;
};

}  // namespace foreland::client
