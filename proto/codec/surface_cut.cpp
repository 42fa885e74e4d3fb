#include "proto/codec/surface_cut.h"

#include <algorithm>

#include "base/check.h"

namespace foreland::proto {

Section SurfaceCut::section() const {
  Section section;
  section.slots.reserve(nodes_);
  pages_.forEachInSection([&](Slot slot) { section.slots.push_back(slot); });
  return section;
}

std::span<const SurfaceCut::Pages::PageName> SurfaceCut::pagesOf(int level) {
  pages_.orderPages();
  return pages_.pagesOf(mesh_->levelOffset(level), mesh_->levelOffset(level + 1));
}

void SurfaceCut::hold(const Section& section) {
  *this = SurfaceCut(*mesh_);
  if (section.slots.empty()) return;
  beginStep();
  for (Slot slot : section.slots) add(pages_.find(slot), lowOf(slot));
  endStep();
}

void SurfaceCut::beginStep() {
  if (has_first_level_) return;
  has_first_level_ = true;
  for (Slot slot = mesh_->levelOffset(1); slot < mesh_->levelOffset(2); ++slot)
    if (!mesh_->isBase(mesh_->node(slot))) addToFrontier(slot);
}

void SurfaceCut::remove(uint32_t page, uint8_t low) {
  const auto [n, level] = nodeAt(page, low);
  pages_.removeFromSection(page, low);
  pages_.page(page).removed.set(low);
  --nodes_;
  for (NodeId child : mesh_->children(n)) removeFromFrontier(mesh_->slot(child, level + 1));
  for (NodeId parent : mesh_->parents(n))
    if (!hasChild(parent, level - 1)) addToFrontier(mesh_->slot(parent, level - 1));
}

void SurfaceCut::add(uint32_t page, uint8_t low) {
  const auto [n, level] = nodeAt(page, low);
  pages_.addToSection(page, low);
  pages_.page(page).added.set(low);
  ++nodes_;
  for (NodeId parent : mesh_->parents(n)) removeFromFrontier(mesh_->slot(parent, level - 1));
  const auto isThere = [&, here = level](NodeId other) { return contains(mesh_->slot(other, here)); };
  for (NodeId child : mesh_->children(n))
    if (mesh_->hasOtherParent(child, n, isThere)) addToFrontier(mesh_->slot(child, level + 1));
}

void SurfaceCut::endStep() {
  pages_.orderPages();
  pages_.dropEmpty();
  for (const Pages::PageName& name : pages_.pages()) {
    Page& page = pages_.page(name.number);
    page.added = page.removed = {};
  }
}

SurfaceCut::At SurfaceCut::nodeAt(uint32_t page, uint8_t low) const {
  const NodeId n = mesh_->node(pages_.page(page).first() + low);
  return {n, mesh_->level(n)};
}

bool SurfaceCut::hasChild(NodeId n, int level) const {
  const auto children = mesh_->children(n);
  return std::any_of(children.begin(), children.end(),
                     [&](NodeId child) { return contains(mesh_->slot(child, level + 1)); });
}

void SurfaceCut::addToFrontier(Slot slot) {
  uint32_t page = pages_.find(slot);
  if (page == Pages::kNone) page = pages_.makePage(slot);
  pages_.addToFrontier(page, lowOf(slot));
}

void SurfaceCut::removeFromFrontier(Slot slot) {
  const uint32_t page = pages_.find(slot);
  if (page != Pages::kNone) pages_.removeFromFrontier(page, lowOf(slot));
}

void SurfaceCut::validate() const {
  pages_.validate();
  size_t nodes = 0;
  for (Slot slot = 0; slot < mesh_->slotCount(); ++slot) {
    const NodeId n = mesh_->node(slot);
    if (mesh_->isBase(n)) continue;
    const auto parents = mesh_->parents(n);
    const bool is_rooted =
        std::all_of(parents.begin(), parents.end(), [&](NodeId p) { return contains(mesh_->slot(p)); });
    const bool is_in = contains(slot), is_on_frontier = is_in ? !hasChild(n, mesh_->level(n)) : is_rooted;
    if (is_in) CHECK_TRUE(is_rooted);
    if (has_first_level_) CHECK_EQ(pages_.isOnFrontier(slot), is_on_frontier);
    nodes += is_in ? 1 : 0;
  }
  CHECK_EQ(nodes, nodes_);
}

}  // namespace foreland::proto
