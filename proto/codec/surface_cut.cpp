#include "proto/codec/surface_cut.h"

#include <algorithm>

#include "base/check.h"

namespace foreland::proto {

namespace {

uint32_t keyOf(Slot slot) { return slot / kPageSlots; }
uint8_t lowOf(Slot slot) { return static_cast<uint8_t>(slot); }

}  // namespace

bool SurfaceCut::contains(Slot slot) const {
  const auto page = pages_.find(keyOf(slot));
  return page != pages_.end() && page->second.in_section.has(lowOf(slot));
}

bool SurfaceCut::wasAdded(Slot slot) const {
  const auto page = pages_.find(keyOf(slot));
  return page != pages_.end() && page->second.added.has(lowOf(slot));
}

Section SurfaceCut::section() const {
  Section section;
  section.slots.reserve(nodes_);
  for (const auto& [key, page] : pages_)
    page.in_section.forEach([&, first = key * kPageSlots](uint8_t low) { section.slots.push_back(first + low); });
  return section;
}

void SurfaceCut::hold(const Section& section) {
  *this = SurfaceCut(*mesh_);
  if (section.slots.empty()) return;
  beginStep();
  for (Slot slot : section.slots) add(pages_.find(keyOf(slot)), lowOf(slot));
  endStep();
}

void SurfaceCut::beginStep() {
  if (is_seeded_) return;
  is_seeded_ = true;
  for (Slot slot = mesh_->levelOffset(1); slot < mesh_->levelOffset(2); ++slot)
    if (!mesh_->isBase(mesh_->node(slot))) list(slot);
}

void SurfaceCut::remove(Pages::iterator page, uint8_t low) {
  const auto [n, level] = nodeAt(page->first, low);
  page->second.in_section.clear(low);
  page->second.removed.set(low);
  --nodes_;
  for (NodeId child : mesh_->children(n)) unlist(mesh_->slot(child, level + 1));
  for (NodeId parent : mesh_->parents(n))
    if (!hasChild(parent, level - 1)) list(mesh_->slot(parent, level - 1));
}

void SurfaceCut::add(Pages::iterator page, uint8_t low) {
  const auto [n, level] = nodeAt(page->first, low);
  page->second.in_section.set(low);
  page->second.added.set(low);
  ++nodes_;
  for (NodeId parent : mesh_->parents(n)) unlist(mesh_->slot(parent, level - 1));
  const auto isThere = [&, here = level](NodeId other) { return contains(mesh_->slot(other, here)); };
  for (NodeId child : mesh_->children(n))
    if (mesh_->hasOtherParent(child, n, isThere)) list(mesh_->slot(child, level + 1));
}

void SurfaceCut::endStep() {
  std::erase_if(pages_, [](const auto& page) { return page.second.isEmpty(); });
  for (auto& [key, page] : pages_) page.added = page.removed = {};
}

SurfaceCut::At SurfaceCut::nodeAt(uint32_t key, uint8_t low) const {
  const NodeId n = mesh_->node(key * kPageSlots + low);
  return {n, mesh_->level(n)};
}

bool SurfaceCut::hasChild(NodeId n, int level) const {
  const auto children = mesh_->children(n);
  return std::any_of(children.begin(), children.end(),
                     [&](NodeId child) { return contains(mesh_->slot(child, level + 1)); });
}

void SurfaceCut::list(Slot slot) { pages_[keyOf(slot)].on_frontier.set(lowOf(slot)); }

void SurfaceCut::unlist(Slot slot) {
  if (const auto page = pages_.find(keyOf(slot)); page != pages_.end()) page->second.on_frontier.clear(lowOf(slot));
}

void SurfaceCut::validate() const {
  size_t nodes = 0;
  for (Slot slot = 0; slot < mesh_->slotCount(); ++slot) {
    const NodeId n = mesh_->node(slot);
    if (mesh_->isBase(n)) continue;
    const auto parents = mesh_->parents(n);
    const bool is_rooted =
        std::all_of(parents.begin(), parents.end(), [&](NodeId p) { return contains(mesh_->slot(p)); });
    const bool is_in = contains(slot), is_on_frontier = is_in ? !hasChild(n, mesh_->level(n)) : is_rooted;
    if (is_in) CHECK_TRUE(is_rooted);
    const auto page = pages_.find(keyOf(slot));
    const bool is_listed = page != pages_.end() && page->second.on_frontier.has(lowOf(slot));
    if (is_seeded_) CHECK_EQ(is_listed, is_on_frontier);
    nodes += is_in ? 1 : 0;
  }
  CHECK_EQ(nodes, nodes_);
}

}  // namespace foreland::proto
