// What refinement of a surface saves and keeps, along the session of S, figure 8: the object turns at a distance at
// which all of it is in view, then the eye comes near. Every figure is measured on the frames themselves: faces after
// cutting at T-vertices, errors by the oracle on every vertex of the full resolution.
#pragma once

#include <vector>

#include "oracle/reference/plain_surface.h"
#include "proto/refine/adapter.h"
#include "terrain/surface/bounds.h"

namespace foreland::lab {

struct SurfaceSession {
  proto::Lens lens{1.0471975511965976, 640, 480};
  double silhouette_px = 0.5;
  double interior_px = 3.5;
  uint32_t turning_frames = 120;  // two rotations, from above to below
  uint32_t zoom_frames = 60;
  double disc = 0.6;  // the object's bounding sphere covers this share of the screen's height while it turns
};

// Where the eye is. The object's bounding sphere is about the middle of its box.
std::vector<proto::Pose> sessionPoses(const terrain::TrueSurface& surface, const SurfaceSession& session);
// The same distance rule, from one direction.
proto::Pose poseAtDisc(const terrain::TrueSurface& surface, const SurfaceSession& session, double disc,
                       const glm::dvec3& direction);

struct FrameCost {
  size_t faces = 0, nodes = 0;
  double silhouette_error_px = 0, interior_error_px = 0;
  uint64_t uncovered = 0;
  double refine_ms = 0, full_draw_ms = 0,
         draw_ms = 0;  // medians of three; draw: of the refined mesh, its walk included
};

// One kind of bound on one surface.
class SurfaceBench {
 public:
  SurfaceBench(const terrain::TrueSurface& surface, proto::ErrorShape shape, terrain::ErrorFit fit);

  FrameCost measure(const SurfaceSession& session, const proto::Pose& pose) const;
  // Faces alone, at tolerances `scale` times the session's.
  size_t faces(const SurfaceSession& session, const proto::Pose& pose, double scale) const;
  // Mean over the poses of the largest measured error, as a share of the tolerance at scale 1.
  double meanWorstShare(const SurfaceSession& session, const std::vector<proto::Pose>& poses, double scale) const;
  // Mean faces with the tolerances scaled until that mean is `share`.
  struct AtEqualError {
    double scale = 1, faces = 0;
  };
  AtEqualError atEqualError(const SurfaceSession& session, const std::vector<proto::Pose>& poses, double share) const;

  // The same section by the adapter that sessions have, which adapts from pose to pose. Returns the milliseconds of
  // this adaptation. CHECKs that it is what refinement from scratch gives.
  double adapt(const SurfaceSession& session, const proto::Pose& pose, proto::SurfaceAdapter& adapter) const;
  proto::SurfaceDomain domain(const SurfaceSession& session) const;

  size_t fullFaces() const { return full_.triangles.size(); }
  double boundsSeconds() const { return bounds_seconds_; }

 private:
  oracle::PlainSection refine(const SurfaceSession& session, const proto::Pose& pose, double scale) const;

  const terrain::TrueSurface& surface_;
  proto::ErrorShape shape_;
  std::vector<proto::SurfaceRecord> records_;
  oracle::SurfaceTruth full_;
  oracle::SurfaceOracle oracle_;
  double nearest_m_;
  double bounds_seconds_ = 0;
};

}  // namespace foreland::lab
