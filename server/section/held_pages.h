// The pages of a scene at a distance (terrain/store/distant_scene.h) that one viewer's sections need, and what is to be
// fetched for it. A node of whose children some are not there cannot be refined; errors are saturated, so with a
// tolerance at which none of those is in the section all that its adaptation reads is there, and the tolerance is kept
// as any other is. Nothing waits for the store.
//
// What was read stays there from a keyframe to the end of the next one, whose adaptation starts from it. A viewer whose
// needs do not fit in the cache aims at a coarser tolerance, at which they do, and comes back slowly when there is
// room; so what fits is the coarser part of what it wants, and nothing is fetched again and again. One owner (a
// session).
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "proto/refine/terrain_batch.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

class HeldPages final : public proto::ReadableNodes {
 public:
  // Of a scene with a supply. `hierarchy` must outlive it.
  explicit HeldPages(const Hierarchy& hierarchy);
  HeldPages(const HeldPages&) = delete;
  HeldPages& operator=(const HeldPages&) = delete;
  ~HeldPages();

  // Whether the page of a node is there, or is none of the scene's; it stays until the next tolerance(), for who
  // measures sections that may never be sent.
  bool isReadable(proto::Slot slot) override;
  // The same; it is held as long as what tolerance() needs.
  bool need(proto::Slot slot);

  // The tolerance to send a section with, the view's or a larger one: all is there that sections and their adaptation
  // read. Called once a keyframe. Wishes for what lacks of the view's own, in the order of its errors on the screen.
  // `view` is as the viewer decodes it. Cost: one refinement from scratch.
  double tolerance(const proto::View& view, proto::RefineScratch& scratch, proto::Section& section);
  // Wishes for what a view of later lacks, after what is needed now. Cost: likewise.
  void expect(const proto::View& view, size_t max_nodes, proto::RefineScratch& scratch, proto::Section& section);
  // How many wishes the last expect() had.
  size_t expected() const { return later_.size(); }
  // Wishes for tiles, in place of those of the last keyframe.
  void expectTiles(std::vector<terrain::ChunkCache::Wish> wishes);

  // After a keyframe: releases what neither it nor the view of later read.
  void endKeyframe();
  // Whether the last keyframe's tolerance was raised for what lacked.
  bool isLacking() const { return is_lacking_; }

 private:
  using Wish = terrain::ChunkCache::Wish;
  class Lacking;
  void addWishes(const Lacking& lacking, const proto::View& view, float share, std::vector<Wish>& wishes,
                 double& tolerance);
  bool hold(proto::Slot slot, uint32_t keyframe, uint64_t& last_page);
  void releaseThose(bool (*which)(uint32_t needed, uint32_t keyframe));
  void tell();
  void aim(double wanted_px);

  const Hierarchy& hierarchy_;
  terrain::ChunkCache& cache_;
  const uint64_t place_count_;
  static constexpr uint32_t kMeasured = 0;
  static constexpr uint64_t kNoPage = ~uint64_t{0};
  // And for which keyframe they were last needed; kMeasured: for none.
  std::unordered_map<terrain::ChunkCache::Chunk, uint32_t> held_;
  uint32_t keyframe_ = 1;
  uint64_t last_measured_ = kNoPage, last_needed_ = kNoPage;  // pages that are held
  std::vector<Wish> now_, later_, tiles_;
  terrain::ChunkCache::Wishes wishes_;
  bool is_lacking_ = false;
  double aim_px_ = 0;      // no finer than that is wished for; 0: than what is wanted
  int full_in_a_row_ = 0;  // keyframes that lacked more than there was room for
  proto::TerrainBatch batch_;
};

}  // namespace foreland::server
