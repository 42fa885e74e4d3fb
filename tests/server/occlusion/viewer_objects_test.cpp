// Along a flight, an object that is called hidden at a keyframe is hidden from all eyes of the intervals in which that
// is shown, however long ago it was found out.
#include "server/occlusion/objects/viewer_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "base/rng.h"
#include "tests/support/hiding_spheres.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

using glm::dvec3;

// Past spheres that stand about in a square, on a path that is known, or guessed with an error.
class ObjectFlight {
 public:
  static constexpr int kKeyframes = 40;

  ObjectFlight(double error_m, Rng& rng) : error_m_(error_m) {
    std::vector<proto::ObjectPlacement> placements;
    for (size_t i = 0; i < 60; ++i)
      placements.push_back({0,
                            {rng.uniform(0, 300), rng.uniform(0, 300), rng.uniform(-4, 4)},
                            {1, 0, 0, 0},
                            i % 4 == 0 ? rng.uniform(15, 25) : rng.uniform(3, 8)});
    objects_ = spheres_.at(placements);
    solids_ = ObjectSolids::create(objects_).value();
  }

  // A guess is off by up to its error, another way each time, and now and then by far more; nor does it always go far.
  PredictedEyePath eyePathAt(int keyframe) const {
    PredictedEyePath eye_path{Duration::milliseconds(200), keyframe, keyframe + 1, {}, error_m_};
    const bool is_elsewhere = error_m_ > 0 && keyframe % 7 == 0;
    const dvec3 off{0, error_m_ * std::sin(2.5 * keyframe), is_elsewhere ? 60 : 0};
    const int ahead = error_m_ > 0 ? 2 + keyframe % 9 : 22;
    for (int i = keyframe; i < keyframe + ahead; ++i)
      eye_path.eyes.push_back({eyeAt(i) + off, eyeAt(i + 1) - eyeAt(i), 0.1 + error_m_});
    return eye_path;
  }
  static proto::View viewAt(int keyframe) {
    proto::View view;
    view.pose = {eyeAt(keyframe), proto::lookAlong({0, 1, 0}, {0, 0, 1})};
    view.lens = {2, 960, 540};
    return view;
  }

  const SceneObjects& objects() const { return objects_; }
  const ObjectSolids& solids() const { return *solids_; }

  // Lines from eyes as far off as may be to the object's vertices that nothing is in the way of.
  uint64_t seen(size_t object, const EyeCapsule& eyes, Rng& rng) const {
    uint64_t seen = 0;
    for (size_t i = 0; i < spheres_.full.size(); i += 2) {
      const dvec3 point = objects_.set.placement(object).toScene(spheres_.full[i][0]);
      dvec3 off{rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
      off *= eyes.radius_m / std::max(1e-6, glm::length(off));
      const dvec3 eye = eyes.eye + static_cast<double>(i % 2) * eyes.way + off;
      for (const auto* drawn : {&spheres_.full, &spheres_.base})
        seen += spheres_.isBetween(objects_, *drawn, object, eye, point) ? 0 : 1;
    }
    return seen;
  }

 private:
  static dvec3 eyeAt(int interval) { return {4.0 * interval, -20, 2}; }

  double error_m_;
  test::HidingSpheres spheres_;
  SceneObjects objects_;
  std::shared_ptr<const ObjectSolids> solids_;
};

// Counts objects that are called hidden, and lines to them that nothing is in the way of.
void flyPast(const ObjectFlight& flight, Rng& rng, uint64_t& hidden, uint64_t& seen) {
  EyeIntervals intervals;
  PathSpans spans(intervals, nullptr, PathSpans::kTight);
  ViewerObjects viewer(flight.objects(), flight.solids());
  for (int keyframe = 1; keyframe <= ObjectFlight::kKeyframes; ++keyframe) {
    const PredictedEyePath eye_path = flight.eyePathAt(keyframe);
    intervals.expect(eye_path);
    const auto number = static_cast<uint32_t>(keyframe);
    spans.revise(number);
    const proto::View view = ObjectFlight::viewAt(keyframe);
    const proto::Frustum frustum(view, 0);
    viewer.begin({view, frustum, SpanProver(intervals, spans, {.worth = 1}, number), intervals, {}, {}});
    for (size_t object = 0; object < flight.objects().set.size(); ++object) {
      if (!viewer.isHidden(object, 100) || !flight.objects().mayBeSeen(object, view, frustum)) continue;
      ++hidden;
      for (size_t i = 0; i < 2; ++i) seen += flight.seen(object, eye_path.eyes[i], rng);
    }
  }
  EXPECT_LT(viewer.queries(), ObjectFlight::kKeyframes * ViewerObjects::kMaxQueries);
}

class ViewerOfObjects : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Errors, ViewerOfObjects, testing::Values(0.0, 0.6, 1.2, 4.0));

// Where guesses are off by much, some flights have hardly anything that is surely hidden.
TEST_P(ViewerOfObjects, HidesObjectsFromAllEyesThatAKeyframeIsShownFor) {
  Rng rng(test::randomSeed());
  uint64_t hidden = 0, seen = 0;
  for (int flights = 0; hidden <= 20 && flights < 100; ++flights)
    flyPast(ObjectFlight(GetParam(), rng), rng, hidden, seen);
  EXPECT_GT(hidden, 20u);
  EXPECT_EQ(seen, 0u);
}

}  // namespace
}  // namespace foreland::server
