// Judges all that is drawn of a scene, terrain and objects, as one: every sample of the terrain (oracle.h) and every
// vertex of every object (surface/objects_oracle.h) that the camera sees.
//
// What is guaranteed differs: the terrain and the silhouettes of objects keep tau, the inside of objects an interior
// tolerance that is a multiple of it. So that one figure can be compared with tau, errors inside objects count divided
// by that multiple, and those against a globe's files less what their residuals look like; their own values are
// reported as well.
//
// One owner. Cost: that of the two oracles.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "oracle/crack_checker.h"
#include "oracle/globe/source_oracle.h"
#include "oracle/oracle.h"
#include "oracle/patchwork.h"
#include "oracle/surface/objects_oracle.h"

namespace foreland::oracle {

struct SceneDeviation : Deviation {  // of everything: a sample is one of the terrain, or a vertex of an object
  double silhouette_px = 0;          // largest on the silhouette of an object
  double interior_px = 0;            // largest inside one, not divided
  uint64_t object_vertices = 0;      // judged
  SourceDeviation sources{};         // of a globe's files, if they are given
};

class SceneOracle {
 public:
  explicit SceneOracle(Truth terrain, ObjectsTruth objects = {})
      : frame_(terrain.frame),
        terrain_(std::move(terrain)),
        objects_(std::make_shared<const ObjectsOracle>(std::move(objects))) {}

  // Of a globe, and of ground that is fine in places only.
  SceneOracle(Patchwork terrain, const proto::Frame& frame, ObjectsTruth objects)
      : frame_(frame),
        terrain_(nothing()),
        patchwork_(std::move(terrain)),
        objects_(std::make_shared<const ObjectsOracle>(std::move(objects))) {}

  // Another judge of the same scene, for another thread, which may work at the same time (Oracle::twin).
  SceneOracle twin() {
    SceneOracle other(frame_, terrain_.twin(), objects_);
    if (patchwork_) other.patchwork_.emplace(patchwork_->twin());
    other.sources_ = sources_;
    other.is_seen_ = is_seen_;
    other.stretch_ = stretch_;
    return other;
  }

  // From now on errors above a frame's tolerance count only where the true point is seen.
  void judgeOnlySeen(std::function<bool(const glm::dvec3& point, const glm::dvec3& eye)> is_seen) {
    is_seen_ = std::move(is_seen);
  }

  // From now on a globe is judged against the files that it was made of, too.
  void judgeSources(SourceOracle sources) { sources_.emplace(std::move(sources)); }

  // From now on heights are drawn so many times as tall. Not of a globe.
  void exaggerate(double factor) {
    stretch_.factor = factor;
    terrain_.setStretch(stretch_);
  }
  const Stretch& stretch() const { return stretch_; }

  // What is drawn is mix(from, to, weight), within `tolerance_px`, as is promised.
  SceneDeviation error(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose,
                       const proto::Lens& lens, double tolerance_px);
  CrackReport findCracks(const client::KeyframeMesh& mesh, const proto::GridShape& shape) const;

  // Of two drawn surfaces of the terrain.
  Deviation difference(Surface a, Surface b, const proto::Pose& pose, const proto::Lens& lens) {
    return patchwork_ ? patchwork_->difference(a, b, pose, lens) : terrain_.difference(a, b, pose, lens);
  }
  const ObjectsOracle& objects() const { return *objects_; }

 private:
  SceneOracle(const proto::FrameTransform& frame, Oracle terrain, std::shared_ptr<const ObjectsOracle> objects)
      : frame_(frame), terrain_(std::move(terrain)), objects_(std::move(objects)) {}

  // The truth of no ground.
  static Truth nothing() {
    return {.frame = {},
            .shape = {.samples_x = 2, .samples_y = 2},
            .heights = [](uint32_t, uint32_t, std::span<int32_t> out) { std::ranges::fill(out, kNoSample); },
            .position = [](uint32_t, uint32_t, double) { return glm::dvec3(0); }};
  }

  // By object: how far the ground has carried it at the time shown, scene frame.
  std::vector<glm::dvec3> carried() const;
  // By model: how much each of its poses contributes at the time shown; empty if it has one.
  std::vector<std::vector<double>> poseShares() const;

  proto::FrameTransform frame_;
  Oracle terrain_;
  std::optional<Patchwork> patchwork_;  // judges the terrain instead
  std::optional<SourceOracle> sources_;
  std::shared_ptr<const ObjectsOracle> objects_;
  std::function<bool(const glm::dvec3& point, const glm::dvec3& eye)> is_seen_;
  Stretch stretch_;
};

}  // namespace foreland::oracle
