#include "lab/sections/errors.h"

#include <algorithm>

#include "base/quantile.h"
#include "client/replica.h"
#include "oracle/lod_motion.h"
#include "oracle/reference/whole_mesh.h"
#include "oracle/scene_truth.h"
#include "server/section/sender.h"
#include "server/session/world.h"

namespace foreland::lab {

namespace {

oracle::SceneOracle oracleOf(const server::Hierarchy& hierarchy) {
  // The scene outlives the oracle.
  std::shared_ptr<const terrain::Scene> scene(&hierarchy.scene(), [](const terrain::Scene*) {});
  const server::SceneObjects& objects = hierarchy.objects();
  oracle::ObjectsTruth truth = oracle::objectsTruth(objects.set, objects.nodes);
  if (scene->grid().isCube()) return oracle::SceneOracle(oracle::globeOracle(scene), scene->frame(), std::move(truth));
  if (scene->isSparse()) return oracle::SceneOracle(oracle::sparseOracle(scene), scene->frame(), std::move(truth));
  return oracle::SceneOracle(oracle::truthOf(std::move(scene)), std::move(truth));
}

class Replay {
 public:
  Replay(const server::Hierarchy& hierarchy, const proto::Path& path, const FlightOptions& options,
         const FrameSampling& sampling)
      : hierarchy_(hierarchy),
        path_(path),
        options_(options),
        frames_per_keyframe_(sampling.frames_per_keyframe),
        replica_(server::welcomeTo(hierarchy)),
        sender_(hierarchy),
        oracle_(oracleOf(hierarchy)) {
    errors_.measure_every = oracle::coprimeStride(sampling.measure_every, frames_per_keyframe_);
    errors_.object_interior_per_tau = oracle_.objects().interiorPerTau();
  }

  void keyframe(const proto::View& view) {
    Bytes message;
    sender_.send(view, Time{} + options_.keyframe_interval * keyframes_++, scratch_, message);
    CHECK_TRUE(replica_.apply(sender_.keyframe(), ByteSpan(message).subspan(sender_.headerBytes())).ok());
    const client::KeyframeMesh mesh = oracle::wholeMesh(replica_);
    errors_.cracks += oracle_.findCracks(mesh, hierarchy_.grid().shape()).cracks;
    const oracle::SceneDeviation error = judge(mesh, 1, view.pose);
    errors_.max_error_px_keyframes = std::max(errors_.max_error_px_keyframes, error.max_px);
    if (keyframes_ == 1) return;
    for (uint32_t f = 0; f < frames_per_keyframe_; ++f)
      if (frame_++ % errors_.measure_every == 0) frame(mesh, f);
    const Time middle = mesh.from.time + Duration{options_.keyframe_interval.us / 2};
    oracle::collectLodMotion(mesh, {}, path_.at(middle), options_.lens, motions_px_);
  }

  SectionErrors finish() {
    errors_.lod_motion_px_per_frame = quantile(motions_px_, 1) / frames_per_keyframe_;
    errors_.lod_motion_px_per_frame_p99 = quantile(motions_px_, 0.99) / frames_per_keyframe_;
    return errors_;
  }

 private:
  void frame(const client::KeyframeMesh& mesh, uint32_t f) {
    const double weight = static_cast<double>(f) / frames_per_keyframe_;
    const Time t = mesh.from.time + Duration{options_.keyframe_interval.us * f / frames_per_keyframe_};
    const oracle::SceneDeviation error = judge(mesh, weight, path_.at(t));
    errors_.weights_judged.add(weight);
    errors_.max_error_px_frames = std::max(errors_.max_error_px_frames, error.max_px);
    errors_.frames_over_tau += error.max_px > options_.tau_px ? 1 : 0;
    errors_.uncovered_samples += error.uncovered;
    ++errors_.frames;
  }

  oracle::SceneDeviation judge(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose) {
    const oracle::SceneDeviation error = oracle_.error(mesh, weight, pose, options_.lens, options_.tau_px);
    errors_.object_vertices_judged += error.object_vertices;
    errors_.object_silhouette_error_px = std::max(errors_.object_silhouette_error_px, error.silhouette_px);
    errors_.object_interior_error_px = std::max(errors_.object_interior_error_px, error.interior_px);
    return error;
  }

  const server::Hierarchy& hierarchy_;
  const proto::Path& path_;
  const FlightOptions& options_;
  uint32_t frames_per_keyframe_;
  client::Replica replica_;
  server::SectionSender sender_;
  server::SendScratch scratch_;
  oracle::SceneOracle oracle_;
  SectionErrors errors_;
  std::vector<double> motions_px_;
  int64_t keyframes_ = 0;
  uint64_t frame_ = 0;
};

}  // namespace

SectionErrors measureErrors(const server::Hierarchy& hierarchy, const std::vector<proto::View>& views,
                            const proto::Path& path, const FlightOptions& options, const FrameSampling& sampling) {
  Replay replay(hierarchy, path, options, sampling);
  for (const proto::View& view : views) replay.keyframe(view);
  return replay.finish();
}

}  // namespace foreland::lab
