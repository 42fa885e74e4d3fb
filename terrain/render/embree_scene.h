// The only place of terrain/render that knows Embree: triangle meshes in floats, and what a ray meets first. Embree's
// types and errors stay in the source file. Threads: one owner until commit(); after it any thread may cast. Building
// uses all processors.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "base/result.h"

namespace foreland::terrain {

// What a ray meets, in Embree's words. Triangles: the point is (1 - u - v, u, v) of the corners. Quads are the two
// triangles (0, 1, 3) and (2, 3, 1); `is_second` says which, and u and v are that triangle's.
struct EmbreeHit {
  static constexpr uint32_t kNone = 0xffffffffu;
  uint32_t geometry = 0;      // in the order of add...; within the instance's scene if there is one
  uint32_t instance = kNone;  // the geometry number of the instance
  uint32_t primitive = 0;
  float u = 0, v = 0;
  bool is_second = false;
};

class EmbreeScene {
 public:
  // Of which Embree takes at most `max_bytes`, with all that share its device.
  explicit EmbreeScene(int64_t max_bytes = std::numeric_limits<int64_t>::max());
  // A scene for instances in `whole`.
  static EmbreeScene partOf(const EmbreeScene& whole);
  ~EmbreeScene();
  EmbreeScene(EmbreeScene&&) noexcept;
  EmbreeScene& operator=(EmbreeScene&&) noexcept;

  // `fill` is called at once, and writes all vertices and all corner numbers; not if there is no memory for them, of
  // which commit() tells.
  using FillQuads = std::function<void(std::span<glm::vec3> vertices, std::span<glm::uvec4> quads)>;
  void addQuads(size_t vertices, size_t quads, const FillQuads& fill);
  void addTriangles(std::span<const glm::vec3> vertices, std::span<const uint32_t> indices);  // copied
  // `part` is committed and outlives this. A point p of it stands at linear * p + offset.
  void addInstance(const EmbreeScene& part, const glm::mat3& linear, const glm::vec3& offset);

  // Builds what makes rays fast; the last call before the first ray. An Error if memory does not suffice.
  [[nodiscard]] Status commit();

  // The first triangle between `nearest` and `farthest`, in lengths of `direction`; edges between triangles let nothing
  // through.
  std::optional<EmbreeHit> cast(const glm::vec3& origin, const glm::vec3& direction, float nearest,
                                float farthest) const;

  // Bytes that Embree holds for this scene and all that share its device.
  uint64_t bytes() const;

 private:
  struct Impl;
  explicit EmbreeScene(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace foreland::terrain
