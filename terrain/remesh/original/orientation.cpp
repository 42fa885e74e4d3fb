#include "terrain/remesh/original/orientation.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace foreland::terrain {

namespace {

class Orienter {
 public:
  Orienter(const std::vector<glm::dvec3>& positions, const std::vector<Triangle>& faces,
           const std::vector<Triangle>& across)
      : positions_(positions), faces_(faces), across_(across), is_seen_(faces.size()) {
    made_.turns.resize(faces.size());
  }

  Orientation run() {
    for (uint32_t seed = 0; seed < faces_.size(); ++seed) {
      if (is_seen_[seed]) continue;
      const bool is_closed = gatherPart(seed);
      if (made_.one_sided != kNoIndex) return std::move(made_);
      const auto turned = std::count_if(part_.begin(), part_.end(), [&](uint32_t f) { return made_.turns[f]; });
      if (2 * static_cast<size_t>(turned) > part_.size()) turnAll(part_);
      if (!is_closed) continue;
      for (uint32_t f : part_) volume_ += (made_.turns[f] ? -1 : 1) * volumeUnder(f);
      closed_.insert(closed_.end(), part_.begin(), part_.end());
    }
    if (volume_ < 0) turnAll(closed_);
    return std::move(made_);
  }

 private:
  // The faces connected with `seed`, turned as it is. Whether they have no border.
  bool gatherPart(uint32_t seed) {
    bool is_closed = true;
    part_.assign(1, seed);
    is_seen_[seed] = true;
    for (size_t i = 0; i < part_.size(); ++i)
      for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t f = part_[i], beyond = across_[f][k];
        if (beyond == kNoIndex)
          is_closed = false;
        else
          visit(f, k, beyond / 3, beyond % 3);
      }
    return is_closed;
  }
  // Neighbours that agree run along their edge in opposite directions.
  void visit(uint32_t f, uint32_t k, uint32_t g, uint32_t edge) {
    const bool turns = made_.turns[f] != (faces_[f][k] == faces_[g][edge]);
    if (is_seen_[g]) {
      if (made_.turns[g] != turns) made_.one_sided = std::min(made_.one_sided, g);
      return;
    }
    is_seen_[g] = true;
    made_.turns[g] = turns;
    part_.push_back(g);
  }
  void turnAll(const std::vector<uint32_t>& faces) {
    for (uint32_t f : faces) made_.turns[f] = !made_.turns[f];
  }
  // Six times the volume between the face and the first position.
  double volumeUnder(uint32_t f) const {
    const Triangle& t = faces_[f];
    const glm::dvec3& origin = positions_.front();
    return glm::dot(positions_[t[0]] - origin, glm::cross(positions_[t[1]] - origin, positions_[t[2]] - origin));
  }

  const std::vector<glm::dvec3>& positions_;
  const std::vector<Triangle>&faces_, &across_;
  Orientation made_;
  std::vector<bool> is_seen_;
  std::vector<uint32_t> part_, closed_;
  double volume_ = 0;
};

}  // namespace

Orientation findOrientation(const std::vector<glm::dvec3>& positions, const std::vector<Triangle>& faces,
                            const std::vector<Triangle>& across) {
  return Orienter(positions, faces, across).run();
}

}  // namespace foreland::terrain
