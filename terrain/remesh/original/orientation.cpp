#include "terrain/remesh/original/orientation.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace foreland::terrain {

namespace {

class Orienter {
 public:
  Orienter(const std::vector<glm::dvec3>& positions, const std::vector<Triangle>& faces,
           const std::vector<Triangle>& twins)
      : positions_(positions), faces_(faces), twins_(twins), is_seen_(faces.size()) {
    made_.is_flipped.resize(faces.size());
  }

  Orientation run() {
    for (uint32_t seed = 0; seed < faces_.size(); ++seed) {
      if (is_seen_[seed]) continue;
      const bool is_closed = gatherComponent(seed);
      if (made_.non_orientable_face != kNoIndex) return std::move(made_);
      const auto flipped =
          std::count_if(component_.begin(), component_.end(), [&](uint32_t f) { return made_.is_flipped[f]; });
      if (2 * static_cast<size_t>(flipped) > component_.size()) flipAll(component_);
      if (!is_closed) continue;
      for (uint32_t f : component_) volume_ += (made_.is_flipped[f] ? -1 : 1) * volumeUnder(f);
      closed_.insert(closed_.end(), component_.begin(), component_.end());
    }
    if (volume_ < 0) flipAll(closed_);
    return std::move(made_);
  }

 private:
  // Gathers the faces connected with `seed` and orients them as it is. Returns whether they have no border.
  bool gatherComponent(uint32_t seed) {
    bool is_closed = true;
    component_.assign(1, seed);
    is_seen_[seed] = true;
    for (size_t i = 0; i < component_.size(); ++i)
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t f = component_[i], twin = twins_[f][k];
        if (twin == kNoIndex)
          is_closed = false;
        else
          visit(f, k, twin / 3, twin % 3);
      }
    return is_closed;
  }
  // Faces with the same orientation traverse their common edge in opposite directions.
  void visit(uint32_t f, uint32_t k, uint32_t g, uint32_t edge) {
    const bool is_flipped = made_.is_flipped[f] != (faces_[f][k] == faces_[g][edge]);
    if (is_seen_[g]) {
      if (made_.is_flipped[g] != is_flipped) made_.non_orientable_face = std::min(made_.non_orientable_face, g);
      return;
    }
    is_seen_[g] = true;
    made_.is_flipped[g] = is_flipped;
    component_.push_back(g);
  }
  void flipAll(const std::vector<uint32_t>& faces) {
    for (uint32_t f : faces) made_.is_flipped[f] = !made_.is_flipped[f];
  }
  // Six times the signed volume of the tetrahedron over the face with its apex at the first position.
  double volumeUnder(uint32_t f) const {
    const Triangle& t = faces_[f];
    const glm::dvec3& origin = positions_.front();
    return glm::dot(positions_[t[0]] - origin, glm::cross(positions_[t[1]] - origin, positions_[t[2]] - origin));
  }

  const std::vector<glm::dvec3>& positions_;
  const std::vector<Triangle>&faces_, &twins_;
  Orientation made_;
  std::vector<bool> is_seen_;
  std::vector<uint32_t> component_, closed_;
  double volume_ = 0;
};

}  // namespace

Orientation findOrientation(const std::vector<glm::dvec3>& positions, const std::vector<Triangle>& faces,
                            const std::vector<Triangle>& twins) {
  return Orienter(positions, faces, twins).run();
}

}  // namespace foreland::terrain
