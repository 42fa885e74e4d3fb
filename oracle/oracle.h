// The truth oracle: judges what is drawn against every full-resolution sample, by brute force. For each sample of the
// terrain that the camera sees, its true position and the position on the drawn mesh at the same lattice position are
// both projected; the distance between them on the screen is the error (THEORY section 3: correspond by
// parameter, never by nearest point). It knows heights, the frame and the drawn triangles, nothing of sections, errors
// or bounds, and shares no code with the refiner, so a mistake of the refiner's cannot hide itself.
//
// A sample is seen if its *true* position is in front of the eye by more than `near_m` along the view direction and
// projects inside the viewport; occlusion is considered only by Sight. A seen sample under no triangle is a hole and
// counts as uncovered.
//
// One owner (it caches heights block by block). Cost: about 15 ns per sample seen and 0.1 microseconds per triangle;
// the first call also reads all heights.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "base/time.h"
#include "client/mesh/patch/keyframe_mesh.h"
#include "oracle/stretch.h"
#include "proto/section/epochs.h"
#include "proto/space/frame_grid.h"
#include "proto/space/pose.h"
#include "proto/topology/grid.h"

namespace foreland::oracle {

// The height of a place where there is no sample.
inline constexpr int32_t kNoSample = std::numeric_limits<int32_t>::min();

// The true surface, sample by sample.
struct Truth {
  proto::Frame frame;
  proto::GridShape shape;
  // Writes the heights (quanta) of samples (x .. x + out.size() - 1, y); called only inside the data.
  std::function<void(uint32_t x, uint32_t y, std::span<int32_t> out)> heights;
  // Where a sample of that height is, if the frame does not say it.
  std::function<glm::dvec3(uint32_t x, uint32_t y, double height)> position{};
  // Of ground that moves in time: the times at which it is given, ascending, and by how many quanta it lies above
  // `heights` then, and how it moves between them. Outside of `moved` it does not. Otherwise empty.
  std::vector<Time> epochs{};
  proto::EpochBlend blend = proto::EpochBlend::kLinear;
  proto::LatticeWindow moved{};
  std::function<void(size_t epoch, uint32_t x, uint32_t y, std::span<double> out)> offsets{};
  // Whether heights are read again where a frame needs them, and only where the ground may be seen from is kept of all.
  bool is_read_on_demand = false;
};

// The time of a truth, for frames of a mesh that leads from one time to another: the mixed time after a step, else a
// mix of the ground at both times. With a linear blend any way that passes no epoch is a step.
struct TruthTime {
  Time from, to;
  double weight = 0;
  bool is_step = false;
  bool operator==(const TruthTime&) const = default;
};

// A share of a drawn mesh: mix(from, to, weight). A surface is a sum of shares whose `share`s add to 1, so the blend of
// two sections needs no union mesh (interpolation is linear in position at equal parameter).
struct DrawnShare {
  const client::KeyframeMesh* mesh = nullptr;
  double weight = 1;
  double share = 1;
};
using Surface = std::span<const DrawnShare>;

// How far two surfaces are apart over the samples seen. Both are piecewise linear with vertices at samples, so the
// largest distance in metres over the samples is exactly the largest over the union mesh; rms values weigh each sample
// alike.
struct Deviation {
  double max_px = 0, rms_px = 0;
  double max_m = 0, rms_m = 0;
  glm::uvec2 worst_sample{0};  // where max_px is
  uint64_t samples = 0;        // seen and covered
  uint64_t uncovered = 0;      // seen, but under no triangle of one of the surfaces
};

// Two of the surfaces that are compared, by index.
struct SurfacePair {
  static constexpr size_t kTruth = ~size_t{0};
  size_t a = 0, b = kTruth;
};

// Which errors count where sections leave out what is hidden: those above a limit only where the true point is seen, in
// the sense of whoever provides it. Any thread.
struct Sight {
  std::function<bool(const glm::dvec3& point, const glm::dvec3& eye)> is_seen;  // scene frame; empty: all is
  double limit_px = 0;

  bool counts(double px, const glm::dvec3& point, const glm::dvec3& eye) const {
    return !is_seen || px <= limit_px || is_seen(point, eye);
  }
};

class Oracle {
 public:
  static constexpr double kDefaultNear_m = 1;

  explicit Oracle(Truth truth, double near_m = kDefaultNear_m);
  ~Oracle();
  Oracle(Oracle&&) noexcept;

  // Another oracle of the same truth, for another thread, which may work at the same time. It shares the heights that
  // do not move, so it costs what it needs for a frame: about 100 bytes for each triangle of the surfaces compared.
  Oracle twin();

  // From now on samples with errors that do not count by this are left out of all comparisons.
  void setSight(Sight sight);
  // From now on pictures are stretched; distances in metres and what is near stay those of the scene.
  void setStretch(const Stretch& stretch);

  // Moves the ground of a truth that has epochs; at first it is as at the first one.
  void showAt(const TruthTime& time);
  // How far the ground at a lattice position, at the nearest one inside the data, has carried what stands there since
  // the first epoch: between samples bilinearly, at each epoch by whole quanta. Quanta.
  double carriedAt(double x, double y) const;

  // At the time shown, of a truth that has epochs: how much each contributes; and their dates.
  std::span<const double> sharesShown() const;
  std::span<const Time> epochs() const;

  // Of a truth that is read on demand: how many blocks' samples are held, 32 KB each, until they are forgotten.
  size_t held() const;
  void forget();

  // The drawn surface against the truth.
  Deviation error(Surface drawn, const proto::Pose& pose, const proto::Lens& lens);
  // Two drawn surfaces against each other, over the samples whose true position is seen.
  Deviation difference(Surface a, Surface b, const proto::Pose& pose, const proto::Lens& lens);
  // Several such comparisons for one camera, over the same samples, so that the triangle inequality holds between them
  // sample by sample, where all surfaces cover. Each surface is rasterised once.
  std::vector<Deviation> compare(std::span<const Surface> surfaces, std::span<const SurfacePair> pairs,
                                 const proto::Pose& pose, const proto::Lens& lens);

 private:
  struct Ground;
  struct Impl;
  explicit Oracle(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace foreland::oracle
