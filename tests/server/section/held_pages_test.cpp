// Sections of a scene at a distance: whatever the store does, a keyframe's section is the one that the whole scene has
// at the tolerance that the keyframe states, and what viewers hold of it is true.
#include "server/section/held_pages.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "client/replica.h"
#include "server/section/sender.h"
#include "server/session/view/keyframe_view.h"
#include "server/session/world.h"
#include "tests/support/far_store.h"
#include "tests/support/globe_scene.h"
#include "tests/support/seed.h"
#include "tests/support/wanderer.h"

namespace foreland::test {
namespace {

using Mood = FarStore::Mood;
using server::Hierarchy;

// A viewer of the scene in the store, and the truth about what it is sent.
class FarViewer {
 public:
  explicit FarViewer(const FarScene& scene)
      : scene_(scene), here_(scene.here), there_(scene.there), sender_(there_), replica_(server::welcomeTo(there_)) {}

  const Hierarchy& hierarchy() const { return here_; }
  server::SectionSender& sender() { return sender_; }
  // Makes a keyframe and returns its tolerance.
  double step(proto::View view) {
    const auto wanted = static_cast<float>(view.tau_px);
    view.tau_px = sender_.toleranceThere(server::asDecoded(view, wanted), scratch_);
    Bytes message;
    sender_.send(view, Time::seconds(++count_), scratch_, message);
    const Status applied = replica_.apply(sender_.keyframe(), ByteSpan(message).subspan(sender_.headerBytes()));
    EXPECT_TRUE(applied.ok()) << applied.error().message;
    EXPECT_GE(sender_.keyframe().tau_px, wanted);
    checkSection();
    return sender_.keyframe().tau_px;
  }

 private:
  void checkSection() {
    proto::Section whole;
    EXPECT_TRUE(server::refine(here_, proto::viewOf(sender_.keyframe()), 1'000'000, scratch_.refine, whole));
    const proto::Section section = replica_.section();
    EXPECT_EQ(section.slots, whole.slots) << "at " << sender_.keyframe().tau_px;
    for (const proto::Slot slot : section.slots) {
      const proto::NodeId n = here_.grid().node(slot);
      ASSERT_EQ(replica_.knownHeight(n), scene_.here->node(n).height()) << slot;
    }
  }

  const FarScene& scene_;
  Hierarchy here_, there_;
  server::SectionSender sender_;
  client::Replica replica_;
  server::SendScratch scratch_;
  int count_ = 0;
};

// What must have happened for the laws to have been tried.
struct Seen {
  int coarser = 0;
  uint64_t evicted = 0;
};

void wander(const FarScene& scene, uint64_t seed, int steps, Seen& seen) {
  FarViewer viewer(scene);
  Wanderer wanderer(viewer.hierarchy(), seed);
  Rng rng(seed);
  for (int i = 0; i < steps && !testing::Test::HasFailure(); ++i) {
    scene.store->mood = rng.below(3) ? Mood::kSound : static_cast<Mood>(rng.below(4));
    for (uint64_t k = rng.below(4); k > 0; --k) (void)scene.cache().fetch();
    const proto::View view = wanderer.next();
    seen.coarser += viewer.step(view) > 1.001 * view.tau_px ? 1 : 0;
    EXPECT_LE(scene.cache().counts().there, scene.cache().counts().capacity);
  }
  seen.evicted += scene.cache().counts().evicted;
}

TEST(HeldPages, KeepWhatKeyframesStateWhateverTheStoreDoes) {
  const uint64_t seed = randomSeed();
  Seen seen;
  wander(farScene(257, 200, seed, 60 * 4096), seed, 250, seen);
  wander(farScene(200, 257, seed + 1, 60 * 4096, proto::FrameKind::kGeographic), seed + 1, 150, seen);
  const TemporaryFolder folder;
  wander(farScene(globeFile(folder, 7, seed, 2), 40 * 4096), seed + 2, 150, seen);
  EXPECT_GT(seen.coarser, 25);
  EXPECT_GT(seen.evicted, 30u);
}

TEST(HeldPages, BringTheSectionOfTheWholeSceneOnceAllIsThere) {
  const FarScene scene = farScene(257, 257, 3, 4 << 20);
  FarViewer viewer(scene);
  proto::View view = viewAt(viewer.hierarchy(), 120, 120, 1500, 0.3, -0.4);
  view.tau_px = 0.5;
  scene.store->mood = Mood::kDead;
  const double cold = viewer.step(view);
  EXPECT_GT(cold, 2.0);
  scene.fetchAll();
  EXPECT_EQ(viewer.step(view), cold);
  scene.store->mood = Mood::kLying;
  for (int i = 0; i < 20; ++i) (void)scene.cache().fetch();
  double last = viewer.step(view);
  EXPECT_LE(last, cold);  // of chunks that are read together only one is not true
  EXPECT_GT(scene.cache().counts().unsound, 0u);
  scene.store->mood = Mood::kSound;
  for (int i = 0; i < 20 && last > view.tau_px; ++i) {
    scene.fetchAll();
    const double now = viewer.step(view);
    EXPECT_LE(now, last);
    last = now;
  }
  EXPECT_EQ(last, view.tau_px);
  EXPECT_FALSE(viewer.sender().pages()->isLacking());
}

// What does not fit stays coarse, and is not fetched again and again.
TEST(HeldPages, FetchNoMoreThanFits) {
  const FarScene scene = farScene(513, 513, 4, 100 * 4096);
  FarViewer viewer(scene);
  proto::View view = viewAt(viewer.hierarchy(), 250, 250, 1500, 0.3, -0.4);
  view.tau_px = 0.25;
  for (int i = 0; i < 60; ++i) {
    (void)viewer.step(view);
    scene.fetchAll();
  }
  const uint64_t fetched = scene.cache().counts().fetched;
  const double tau_px = viewer.step(view);
  EXPECT_GT(tau_px, view.tau_px);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(viewer.step(view), tau_px);
    scene.fetchAll();
  }
  EXPECT_EQ(scene.cache().counts().fetched, fetched);
}

// Nothing stays held for a viewer that has left.
TEST(HeldPages, AreReleasedWithTheirViewer) {
  const FarScene scene = farScene(257, 257, 5, 4 << 20);
  const uint64_t always = scene.cache().counts().held;
  {
    FarViewer viewer(scene);
    for (int i = 0; i < 4; ++i) {
      (void)viewer.step(viewAt(viewer.hierarchy(), 60 + 40 * i, 120, 900, 0.3, -0.4));
      scene.fetchAll();
    }
    EXPECT_GT(scene.cache().counts().held, always);
  }
  EXPECT_EQ(scene.cache().counts().held, always);
}

}  // namespace
}  // namespace foreland::test
