// Judges what is drawn of a globe against the files that it was made of: each sample that its file alone makes the
// ground of (source_samples.h), put into space by GeographicLib, against the point that is drawn at the same place of
// the cube. The scene's own ground is off the samples by what it states of each file, its residual, and by how its
// triangles bend along the ground; so of a sample's error on the screen counts what is more than that looks like there.
// What is left is the error of what is drawn against the scene, and must be within its tolerance.
//
// It takes from the scene what it states of its inputs and which pages are there, but no height.
//
// Any thread; twins share the samples, 40 bytes each. Cost: about 50 ns a sample in view.
#pragma once

#include <memory>
#include <vector>

#include "oracle/globe/source_samples.h"
#include "oracle/oracle.h"

namespace foreland::oracle {

struct SourceDeviation {
  double max_px = 0;     // largest distance of a sample from what is drawn
  double excess_px = 0;  // largest that is more than what its file's residual looks like
  uint64_t samples = 0;  // seen and covered
  uint64_t uncovered = 0;
};

class SourceOracle {
 public:
  SourceOracle(const terrain::Scene& scene, const std::vector<SourceBlock>& blocks);

  // What lies behind the body counts as in globe_oracle.h.
  SourceDeviation error(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose,
                        const proto::Lens& lens, const Sight& sight) const;

 private:
  struct Ground;
  std::shared_ptr<const Ground> ground_;
};

}  // namespace foreland::oracle
