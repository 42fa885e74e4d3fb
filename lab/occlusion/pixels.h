// What a viewer's pixels show, judged by rays on the scene at full resolution (terrain/render): a pixel is wrong if the
// terrain it shows is drawn more than the tolerance away. Both ways round: the true point that a pixel shows may be
// drawn elsewhere, and a pixel may show something drawn whose true place is elsewhere (a coarse valley floor that rises
// above the ridge in front of it). Pure; uses all processors. About 3 microseconds a pixel and processor.
#pragma once

#include <cstdint>
#include <span>

#include "client/mesh/patch/keyframe_mesh.h"
#include "oracle/line_of_sight.h"
#include "terrain/render/picture.h"

namespace foreland::lab {

struct PixelCounts {
  uint64_t pixels = 0;
  uint64_t hidden_objects_seen = 0;       // true points of objects whose nodes are left out as hidden
  uint64_t visible_over_tau = 0;          // true points drawn more than tau away where hidden nodes are left out
  uint64_t visible_over_tau_without = 0;  // the same pixels' where none are
  uint64_t visible_over_tau_hidden = 0;   // over where they are left out, and not where none are: thought hidden
  uint64_t drawn_over_tau_hidden = 0;     // the same of the drawn points that the pixels show
  double max_px = 0;                      // of true points that are drawn where hidden nodes are left out

  void add(const PixelCounts& other);
};

// What is drawn of the same scene at the same moment, with hidden nodes left out and without.
struct DrawnPair {
  const client::KeyframeMesh &with, &without;
  double weight;                            // of the meshes' later ends
  std::span<const uint8_t> hidden_objects;  // at either end
};

class PixelJudge {
 public:
  // `truth` and `terrain` are of one scene and outlive the judge.
  PixelJudge(const terrain::RayCaster& truth, const oracle::LineOfSight& terrain) : truth_(truth), terrain_(terrain) {}

  // Pixels of objects count where these are hidden; others are drawn alike in both. An Error if memory does not
  // suffice.
  Result<PixelCounts> judge(const DrawnPair& drawn, const terrain::Camera& camera, double tau_px) const;

 private:
  const terrain::RayCaster& truth_;
  const oracle::LineOfSight& terrain_;
};

}  // namespace foreland::lab
