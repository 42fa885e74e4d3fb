#include "sim/client_drape.h"

#include <limits>
#include <utility>

namespace foreland::sim {

namespace {

DrawnTiles tilesOf(const std::vector<client::Residency::Shown>& shown, float weight) {
  DrawnTiles tiles;
  for (const client::Residency::Shown& each : shown)
    tiles[each.tile.key()] = each.fade == client::Residency::Fade::kComing  ? 1 - weight
                             : each.fade == client::Residency::Fade::kGoing ? weight
                                                                            : 0;
  return tiles;
}

}  // namespace

void ClientDrape::onKeyframe(const client::Viewer& viewer) {
  if (!drape_) drape_.emplace(viewer.tiles(), client::Drape::Sizes{});
  while (drape_->decodeRelief()) {}
  while (const auto image = drape_->takeWantedImage()) drape_->setImageReady(*image);
  const client::Interval* newest = viewer.timeline().newest();
  drape_->advance(viewer.frameGrid().transform(), newest->from, newest->to);
  meshes_[newest->version] = {drape_->residency(content_)->shown(), drape_->texelPx(content_)};
}

std::optional<ClientDrape::Handover> ClientDrape::handoverTo(uint32_t mesh_version) {
  const auto before = meshes_.find(std::exchange(drawn_version_, mesh_version)), after = meshes_.find(mesh_version);
  if (before == after || before == meshes_.end() || after == meshes_.end()) return std::nullopt;
  return Handover{tilesOf(before->second.shown, 1), tilesOf(after->second.shown, 0)};
}

DrawnTiles ClientDrape::drawn(uint32_t mesh_version, float weight) {
  const auto mesh = meshes_.find(mesh_version);
  if (mesh == meshes_.end()) return {};
  meshes_.erase(meshes_.begin(), mesh);
  return tilesOf(mesh->second.shown, weight);
}

double ClientDrape::texelPx(uint32_t mesh_version) const {
  const auto mesh = meshes_.find(mesh_version);
  return mesh == meshes_.end() ? std::numeric_limits<double>::infinity() : mesh->second.texel_px;
}

}  // namespace foreland::sim
