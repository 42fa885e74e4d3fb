// A host of the C interface in a test: it knows foreland.h alone, keeps the mesh as an engine would, and flies.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "client/c/foreland.h"
#include "client/mesh/patch/keyframe_mesh.h"

namespace foreland::test {

inline ForelandOptions fastOptions() {
  ForelandOptions options = FORELAND_INIT(ForelandOptions);
  options.keyframe_ms = 20;
  return options;
}

// The arrays of a part, brought up to date by updates.
class HostedPart {
 public:
  explicit HostedPart(client::BlendMesh& mesh) : mesh_(&mesh) {}

  void apply(const ForelandPart& part) {
    take(part.from_positions, mesh_->from_positions);
    take(part.to_positions, mesh_->to_positions);
    take(part.from_normals, mesh_->from_normals);
    take(part.to_normals, mesh_->to_normals);
    take(part.from_bends, mesh_->from_bends);
    take(part.to_bends, mesh_->to_bends);
    take(part.parameters, mesh_->parameters);
    take(part.triangles, mesh_->indices, 3);
    EXPECT_EQ(part.triangles.count, mesh_->indices.size() / 3);
  }

 private:
  template <class T>
  static void take(const ForelandChannel& channel, std::vector<T>& values, uint32_t items = 1) {
    values.resize(size_t{channel.count} * items);
    const auto* from = static_cast<const char*>(channel.data);
    for (uint32_t i = 0; i < channel.range_count; ++i) {
      const uint32_t begin = channel.ranges[2 * i], end = channel.ranges[2 * i + 1];
      ASSERT_LT(begin, end);
      ASSERT_LE(end, channel.count);
      if (i > 0) { ASSERT_LT(channel.ranges[2 * i - 1], begin); }
      const size_t bytes = (end - begin) * items * sizeof(T);
      std::memcpy(static_cast<void*>(values.data() + size_t{begin} * items), from, bytes);
      from += bytes;
    }
  }
  client::BlendMesh* mesh_;
};

class Host {
 public:
  explicit Host(uint16_t port, ForelandOptions options = fastOptions()) {
    const std::string server = "ws://127.0.0.1:" + std::to_string(port);
    EXPECT_EQ(foreland_open(server.c_str(), &options, &terrain_), FORELAND_OK) << foreland_last_error();
  }
  ~Host() { foreland_close(terrain_); }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  ForelandTerrain* operator*() const { return terrain_; }

  // Looking down from `above_m` over the highest ground, where the scene is `x` and `y` of its way.
  ForelandPose poseAt(double x, double y, double above_m = 300) const {
    const ForelandScene s = scene();
    return {{s.low[0] + x * (s.high[0] - s.low[0]), s.low[1] + y * (s.high[1] - s.low[1]), s.high[2] + above_m},
            {0, 0, 0, 1}};
  }
  ForelandScene scene() const {
    ForelandScene scene = FORELAND_INIT(ForelandScene);
    EXPECT_EQ(foreland_get_scene(terrain_, &scene), FORELAND_OK) << foreland_last_error();
    return scene;
  }
  ForelandStats stats() const {
    ForelandStats stats = FORELAND_INIT(ForelandStats);
    EXPECT_EQ(foreland_get_stats(terrain_, &stats), FORELAND_OK);
    return stats;
  }

  // The next event of a kind, which must come within 30 s; `meanwhile` is done again and again.
  const ForelandEvent& waitFor(
      uint32_t kind, const std::function<void()>& meanwhile = [] {}) {
    for (const double begin = foreland_now(); foreland_now() - begin < 30'000;) {
      meanwhile();
      while (foreland_next_event(terrain_, &event_) == FORELAND_OK) {
        kinds_.push_back(event_.kind);
        if (event_.kind == kind) return event_;
      }
      foreland_wait(terrain_, 5);
    }
    ADD_FAILURE() << "no event of kind " << kind << " came";
    return event_ = FORELAND_INIT(ForelandEvent);
  }
  // Kinds of all events so far.
  const std::vector<uint32_t>& kinds() const { return kinds_; }

  // A frame, with the mesh brought to its version.
  const ForelandFrame& frame(const ForelandPose& pose) {
    EXPECT_EQ(foreland_frame(terrain_, foreland_now(), &pose, &frame_), FORELAND_OK) << foreland_last_error();
    ForelandUpdate update = FORELAND_INIT(ForelandUpdate);
    while (version_ < frame_.version && foreland_next_update(terrain_, &update) == FORELAND_OK) {
      version_ = update.version;
      mesh_.origin = {update.origin[0], update.origin[1], update.origin[2]};
      terrain_part_.apply(update.terrain);
      objects_part_.apply(update.objects);
      ++updates_;
    }
    return frame_;
  }
  // Frames along a line, until there have been so many more updates; at most 30 s.
  void fly(
      uint32_t updates, const std::function<void(const ForelandFrame&)>& on_frame = [](const ForelandFrame&) {}) {
    const double begin = foreland_now();
    for (const uint32_t until = updates_ + updates; updates_ < until && foreland_now() - begin < 30'000;) {
      const double way = 0.5 + 0.3 * std::sin((foreland_now() - begin) / 2000);
      on_frame(frame(poseAt(way, 0.5)));
      foreland_wait(terrain_, 1);
    }
    EXPECT_LT(foreland_now() - begin, 30'000) << "no meshes came";
  }
  void forgetMesh() {
    version_ = 0;
    mesh_ = {};
  }

  const client::KeyframeMesh& mesh() const { return mesh_; }
  uint32_t version() const { return version_; }
  uint32_t updates() const { return updates_; }

 private:
  ForelandTerrain* terrain_ = nullptr;
  ForelandEvent event_ = FORELAND_INIT(ForelandEvent);
  ForelandFrame frame_ = FORELAND_INIT(ForelandFrame);
  std::vector<uint32_t> kinds_;
  client::KeyframeMesh mesh_;
  HostedPart terrain_part_{mesh_}, objects_part_{mesh_.objects};
  uint32_t version_ = 0, updates_ = 0;
};

}  // namespace foreland::test
