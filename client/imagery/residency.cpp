#include "client/imagery/residency.h"

#include <algorithm>

#include "base/check.h"
#include "base/sort.h"

namespace foreland::client {

namespace {

// Selected as finely as a screen can show, for where ground is seen at an angle texels are wider than high; the server
// sends what it guarantees, and more where that is of use.
constexpr double kTexelPx = 0.5;
// Selected at most: far more than a view sees.
constexpr size_t kMaxSeen = 4096;

}  // namespace

Residency::Residency(const proto::TileLayer& layer, uint8_t index, uint32_t texture_layers)
    : layer_(layer), index_(index), residents_(texture_layers) {
  CHECK_GE(texture_layers, 8u);
  page_table_.resize(size_t{layer.levels()} * kPageSide * kPageSide * 4);
}

Residency::Resident* Residency::find(const proto::TileId& tile) {
  const auto it = places_.find(tile.key());
  return it == places_.end() ? nullptr : &residents_[it->second];
}

// At both ends of the mesh, without fading.
bool Residency::isDrawnThroughout(const proto::TileId& tile) {
  const Resident* r = find(tile);
  return r != nullptr && r->came < mesh_ && r->went == 0;
}

bool Residency::hasDrawnChild(const proto::TileId& tile) {
  if (tile.level == 0) return false;
  for (uint32_t k = 0; k < 4; ++k) {
    const Resident* child = find(tile.child(k));
    if (child != nullptr && isDrawn(*child)) return true;
  }
  return false;
}

// Its parent's image was drawn at the end of the mesh before.
bool Residency::canCome(const proto::TileId& tile) {
  if (layer_.isCoarsest(tile)) return true;
  const Resident* parent = find(tile.parent());
  return parent != nullptr && parent->went == 0 && parent->came < mesh_;
}

// On a globe pages of faces that meet lie side by side, and those of opposite ones, where they are few.
size_t Residency::pageOf(const proto::TileId& tile) const {
  uint32_t x = tile.x, y = tile.y;
  if (layer_.isGlobe()) {
    const uint32_t face = layer_.faceOf(tile), bits = layer_.faceBits(tile.level), half = kPageSide / 2;
    x = layer_.columnOf(tile) + (face % 3 == 1 ? half : 0) + (bits < 4 ? face / 3 << bits : 0);
    y += face % 3 == 2 ? half : 0;
  }
  return (size_t{tile.level} * kPageSide + y % kPageSide) * kPageSide + x % kPageSide;
}

void Residency::advance(const proto::FrameTransform& frame, const proto::View& to, const proto::View& expected,
                        const proto::TileLookup& held) {
  ++mesh_;
  arrivals_.clear(), dropped_.clear(), pages_.clear(), in_the_way_.clear();
  for (uint32_t i = 0; i < residents_.size(); ++i)
    if (isDrawn(residents_[i])) pages_[pageOf(residents_[i].tile)] = i;
  select(frame, to, expected, held);
  forgetUnselected();
  admit();
  makeRoom();
  write();
  measure();
}

void Residency::select(const proto::FrameTransform& frame, const proto::View& to, const proto::View& expected,
                       const proto::TileLookup& held) {
  const auto lookup = [&](const proto::TileId& tile) -> std::optional<proto::TileBounds> {
    if (const Resident* r = find(tile)) return r->bounds;
    return held(tile);
  };
  // The rest is for those that go.
  const size_t most = residents_.size() - residents_.size() / 8;
  selectTiles(layer_, index_, frame, to, kTexelPx, kMaxSeen, lookup, seen_);
  selectTiles(layer_, index_, frame, expected, kTexelPx, kMaxSeen, lookup, expected_);
  selected_ = seen_;
  std::unordered_map<uint64_t, uint32_t> numbers;
  for (uint32_t i = 0; i < selected_.size(); ++i) numbers[selected_[i].tile.key()] = i;
  for (const proto::SelectedTile& s : expected_) {
    if (const auto it = numbers.find(s.tile.key()); it != numbers.end())
      selected_[it->second].texel_px = std::max(selected_[it->second].texel_px, s.texel_px);
    else
      selected_.push_back(s);
  }
  keepLargest(most);
  bounds_.clear();
  for (const proto::SelectedTile& s : selected_) {
    bounds_.emplace(s.tile.key(), *lookup(s.tile));
    if (Resident* r = find(s.tile)) r->selected = mesh_;
  }
}

// Of what is selected the tiles that are largest on the screen, with every tile its parent, and no two of the same
// page.
void Residency::keepLargest(size_t most) {
  foreland::sort(selected_.begin(), selected_.end(), [&](const proto::SelectedTile& a, const proto::SelectedTile& b) {
    const bool is_coarsest = layer_.isCoarsest(a.tile);
    if (is_coarsest != layer_.isCoarsest(b.tile)) return is_coarsest;
    return a.texel_px != b.texel_px ? a.texel_px > b.texel_px : a.tile.key() > b.tile.key();
  });
  std::unordered_set<uint64_t> kept;
  std::unordered_set<size_t> pages;
  std::erase_if(selected_, [&](const proto::SelectedTile& s) {
    if (kept.size() == most || (!layer_.isCoarsest(s.tile) && !kept.contains(s.tile.parent().key()))) return true;
    if (!pages.insert(pageOf(s.tile)).second) return true;
    kept.insert(s.tile.key());
    return false;
  });
}

void Residency::forgetUnselected() {
  std::erase_if(taken_, [&](uint64_t key) {
    if (bounds_.contains(key) || places_.contains(key)) return false;
    dropped_.push_back(proto::TileId::of(key));
    ready_.erase(key);
    return true;
  });
}

void Residency::admit() {
  for (const proto::SelectedTile& s : selected_) {
    const Resident* r = find(s.tile);
    if (r != nullptr && r->went == 0) continue;
    if (arrivals_.size() == kMaxArrivals) break;
    if (canCome(s.tile)) addIfReady(s.tile);
  }
}

// If there is a layer and a page for it, too.
void Residency::addIfReady(const proto::TileId& tile) {
  const size_t page = pageOf(tile);
  if (const auto other = pages_.find(page); other != pages_.end()) {
    in_the_way_.push_back(other->second);
    return;
  }
  std::optional<uint32_t> place;
  if (const auto it = places_.find(tile.key()); it != places_.end()) {
    place = it->second;  // its texels are still there
  } else if (ready_.contains(tile.key())) {
    if (!(place = takeLayer())) return;
    std::optional<uint32_t> parent;
    if (const auto at = places_.find(tile.parent().key()); at != places_.end()) parent = at->second;
    arrivals_.push_back({tile, *place, parent});
  } else {
    return;
  }
  residents_[*place] = {tile, bounds_.at(tile.key()), mesh_, 0, mesh_};
  places_[tile.key()] = *place;
  pages_[page] = *place;
}

// A layer that nothing draws now, nor while what is decided here is uploaded.
std::optional<uint32_t> Residency::takeLayer() {
  std::optional<uint32_t> best;
  for (uint32_t i = 0; i < residents_.size(); ++i) {
    const Resident& r = residents_[i];
    if (r.came == 0) return i;
    if (r.went > 0 && r.went + 2 <= mesh_ && (!best || r.went < residents_[*best].went)) best = i;
  }
  if (!best) return std::nullopt;
  const proto::TileId tile = residents_[*best].tile;
  places_.erase(tile.key());
  taken_.erase(tile.key());
  ready_.erase(tile.key());
  dropped_.push_back(tile);
  residents_[*best] = {};
  return best;
}

// Lets tiles go that are not selected, as many as others wait for, the longest unselected first.
void Residency::makeRoom() {
  size_t wanted = 0, available = 0;
  for (const proto::SelectedTile& s : selected_) {
    const Resident* r = find(s.tile);
    if (r == nullptr) ++wanted;
  }
  for (const Resident& r : residents_)
    if (r.came == 0 || r.went > 0) ++available;
  wanted = std::min(wanted, residents_.size() / 4);
  const auto canGo = [&](const Resident& r) {
    return r.came > 0 && r.went == 0 && r.selected < mesh_ && !hasDrawnChild(r.tile);
  };
  for (const uint32_t i : in_the_way_)
    if (canGo(residents_[i])) residents_[i].went = mesh_, ++available;
  while (available < wanted) {
    Resident* oldest = nullptr;
    for (Resident& r : residents_)
      if (canGo(r) && (oldest == nullptr || r.selected < oldest->selected)) oldest = &r;
    if (oldest == nullptr) return;
    oldest->went = mesh_, ++available;
  }
}

void Residency::write() {
  shown_.clear();
  std::fill(page_table_.begin(), page_table_.end(), uint16_t{0});
  for (uint32_t i = 0; i < residents_.size(); ++i) {
    const Resident& r = residents_[i];
    if (!isDrawn(r)) continue;
    const Fade fade = r.went == mesh_ ? Fade::kGoing : r.came == mesh_ ? Fade::kComing : Fade::kNone;
    shown_.push_back({r.tile, i, fade});
    uint16_t* entry = &page_table_[pageOf(r.tile) * 4];
    entry[0] = static_cast<uint16_t>(r.tile.x / kPageSide);
    entry[1] = static_cast<uint16_t>(r.tile.y / kPageSide);
    entry[2] = static_cast<uint16_t>(i + 1);
    entry[3] = static_cast<uint16_t>(fade);
  }
}

void Residency::measure() {
  texel_px_ = 0;
  const auto isShown = [&](const proto::TileId& tile) { return isDrawnThroughout(tile); };
  for (const proto::SelectedTile& s : seen_)
    if (!isShown(s.tile)) texel_px_ = std::max(texel_px_, texelInPlaceOf(s, layer_, isShown));
}

std::optional<proto::TileId> Residency::takeWanted() {
  for (const proto::SelectedTile& s : selected_) {
    const uint64_t key = s.tile.key();
    if (places_.contains(key) || taken_.contains(key)) continue;
    taken_.insert(key);
    return s.tile;
  }
  return std::nullopt;
}

void Residency::setReady(const proto::TileId& tile) {
  if (taken_.contains(tile.key())) ready_.insert(tile.key());
}

}  // namespace foreland::client
