#include "terrain/town/shell.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <tuple>

namespace foreland::terrain {

namespace {

using glm::dvec2, glm::dvec3;

constexpr double kSame_m = 1e-9;

using Polygon = std::vector<dvec3>;

// A wall from p to q, seen from outside with p on the left; its top goes straight from above p to above q.
struct Wall {
  dvec2 p, q;
  std::array<double, 2> bottom, top;
  Colour colour;
};

class Shell {
 public:
  Shell(const std::vector<Part>& parts, double bottom_m, const Facade& facade)
      : parts_(parts), bottom_m_(bottom_m), facade_(facade) {
    for (const Part& part : parts) {
      xs_.insert(xs_.end(), {part.low.x, part.high.x});
      ys_.insert(ys_.end(), {part.low.y, part.high.y});
      xs_.insert(xs_.end(), part.xs.begin(), part.xs.end());
      ys_.insert(ys_.end(), part.ys.begin(), part.ys.end());
    }
    for (std::vector<double>* lines : {&xs_, &ys_}) {
      std::ranges::sort(*lines);
      const auto isSame = [](double a, double b) { return b - a < kSame_m; };
      lines->erase(std::unique(lines->begin(), lines->end(), isSame), lines->end());
    }
  }

  Model make(const std::string& name) {
    for (size_t j = 0; j + 1 < ys_.size(); ++j)
      for (size_t i = 0; i + 1 < xs_.size(); ++i)
        if (const Part* part = partAt(i, j)) addCell(*part, i, j);
    for (size_t j = 0; j < ys_.size(); ++j)
      for (size_t i = 0; i < xs_.size(); ++i) {
        // Seen from the south, or from the west, the left end of each line's piece comes first.
        if (i + 1 < xs_.size()) addWalls(partAt(i, j), partAt(i, j - 1), {xs_[i], ys_[j]}, {xs_[i + 1], ys_[j]});
        if (j + 1 < ys_.size()) addWalls(partAt(i, j), partAt(i - 1, j), {xs_[i], ys_[j + 1]}, {xs_[i], ys_[j]});
      }
    return finish(name);
  }

 private:
  // Null outside of all parts; indices may be one out of range, either way.
  const Part* partAt(size_t i, size_t j) const {
    if (i >= xs_.size() - 1 || j >= ys_.size() - 1) return nullptr;
    const dvec2 middle{(xs_[i] + xs_[i + 1]) / 2, (ys_[j] + ys_[j + 1]) / 2};
    const Part* found = nullptr;
    for (const Part& part : parts_)
      if (middle.x > part.low.x && middle.x < part.high.x && middle.y > part.low.y && middle.y < part.high.y)
        found = &part;
    return found;
  }
  void add(Polygon polygon, const Colour& colour) {
    polygons_.push_back(std::move(polygon));
    colours_.push_back(colour);
  }

  void addCell(const Part& part, size_t i, size_t j) {
    const std::array<dvec2, 4> corners{dvec2(xs_[i], ys_[j]), dvec2(xs_[i + 1], ys_[j]), dvec2(xs_[i + 1], ys_[j + 1]),
                                       dvec2(xs_[i], ys_[j + 1])};
    Polygon roof, floor;
    for (const dvec2& c : corners) roof.emplace_back(c, part.height(c)), floor.emplace_back(c, bottom_m_);
    std::ranges::reverse(floor);
    add(std::move(floor), part.wall);
    const double middle = part.height((corners[0] + corners[2]) / 2.0), one = (roof[0].z + roof[2].z) / 2,
                 other = (roof[1].z + roof[3].z) / 2;
    if (std::fabs(one - other) < kSame_m) return add(std::move(roof), part.roof);
    const size_t from = std::fabs(one - middle) <= std::fabs(other - middle) ? 0 : 1;
    for (const size_t k : {from, from + 2}) add({roof[k], roof[(k + 1) % 4], roof[(k + 2) % 4]}, part.roof);
  }

  // Between the part on the left side of the way from p to q and that on the right, of which either may be missing.
  void addWalls(const Part* left, const Part* right, const dvec2& p, const dvec2& q) {
    const auto tops = [&](const Part* part) {
      return part ? std::array{part->height(p), part->height(q)} : std::array{bottom_m_, bottom_m_};
    };
    const auto of_left = tops(left), of_right = tops(right);
    if (of_left[0] - of_right[0] + of_left[1] - of_right[1] > kSame_m)
      addWall({p, q, of_right, of_left, left->wall}, left->has_windows && !right);
    else if (of_right[0] - of_left[0] + of_right[1] - of_left[1] > kSame_m)
      addWall({q, p, {of_left[1], of_left[0]}, {of_right[1], of_right[0]}, right->wall}, right->has_windows && !left);
  }

  void addWall(const Wall& wall, bool has_windows) {
    const double length = glm::length(wall.q - wall.p), top = std::min(wall.top[0], wall.top[1]);
    const auto windows = static_cast<int>(std::floor((length - 0.6) / facade_.pitch_m));
    const auto storeys = static_cast<int>(std::floor((top - facade_.sill_m - facade_.window_m) / facade_.storey_m)) + 1;
    if (!has_windows || windows < 1 || storeys < 1) return addPlain(wall);
    std::vector<double> along{0};
    for (int i = 0; i < windows; ++i) {
      const double middle = (i + 0.5) * length / windows;
      along.insert(along.end(), {middle - facade_.width_m / 2, middle + facade_.width_m / 2});
    }
    along.push_back(length);
    double below = bottom_m_;
    for (int storey = 0; storey < storeys; ++storey) {
      const double sill = storey * facade_.storey_m + facade_.sill_m, lintel = sill + facade_.window_m;
      addBand(wall, along, {below, sill}, storey > 0);
      for (size_t i = 0; i + 1 < along.size(); ++i)
        i % 2 == 1 ? addWindow(wall, {along[i], along[i + 1]}, {sill, lintel})
                   : add(rectangle(wall, {along[i], along[i + 1]}, {sill, lintel}), wall.colour);
      below = lintel;
    }
    Polygon last;
    for (const double a : along) last.push_back(on(wall, a, below));
    last.emplace_back(wall.q, wall.top[1]);
    last.emplace_back(wall.p, wall.top[0]);
    add(std::move(last), wall.colour);
  }

  void addPlain(const Wall& wall) {
    Polygon polygon{{wall.p, wall.bottom[0]}, {wall.q, wall.bottom[1]}};
    if (wall.top[1] - wall.bottom[1] > kSame_m) polygon.emplace_back(wall.q, wall.top[1]);
    if (wall.top[0] - wall.bottom[0] > kSame_m) polygon.emplace_back(wall.p, wall.top[0]);
    add(std::move(polygon), wall.colour);
  }
  // From side to side of the wall, with the vertices of the windows above, and below if there are any.
  void addBand(const Wall& wall, const std::vector<double>& along, std::array<double, 2> z, bool has_below) {
    Polygon polygon;
    for (size_t i = 0; i < along.size(); ++i)
      if (has_below || i == 0 || i + 1 == along.size()) polygon.push_back(on(wall, along[i], z[0]));
    for (size_t i = along.size(); i-- > 0;) polygon.push_back(on(wall, along[i], z[1]));
    add(std::move(polygon), wall.colour);
  }
  void addWindow(const Wall& wall, std::array<double, 2> along, std::array<double, 2> z) {
    const dvec2 u = (wall.q - wall.p) / glm::length(wall.q - wall.p);
    const dvec3 in(-u.y * facade_.recess_m, u.x * facade_.recess_m, 0);
    const Polygon rim = rectangle(wall, along, z);
    Polygon pane = rim;
    for (dvec3& p : pane) p += in;
    for (size_t k = 0; k < 4; ++k) add({rim[k], rim[(k + 1) % 4], pane[(k + 1) % 4], pane[k]}, wall.colour);
    add(std::move(pane), facade_.window);
  }
  static dvec3 on(const Wall& wall, double along, double z) {
    const double length = glm::length(wall.q - wall.p);
    if (along == 0) return {wall.p, z};
    return {along == length ? wall.q : wall.p + (wall.q - wall.p) * (along / length), z};
  }
  static Polygon rectangle(const Wall& wall, std::array<double, 2> along, std::array<double, 2> z) {
    return {on(wall, along[0], z[0]), on(wall, along[1], z[0]), on(wall, along[1], z[1]), on(wall, along[0], z[1])};
  }

  // Vertices by position; where one lies on another polygon's upright side, that polygon gets it, too.
  Model finish(const std::string& name) {
    std::map<std::tuple<double, double>, std::vector<double>> uprights;
    for (const Polygon& polygon : polygons_)
      for (const dvec3& p : polygon) uprights[{p.x, p.y}].push_back(p.z);
    Model model;
    model.name = name;
    std::map<std::tuple<double, double, double>, uint32_t> numbers;
    const auto push = [&](const dvec3& p) {
      const auto [at, is_new] = numbers.try_emplace({p.x, p.y, p.z}, static_cast<uint32_t>(model.positions.size()));
      if (is_new) model.positions.push_back(p);
      model.corners.push_back({at->second, kNoIndex});
    };
    for (size_t f = 0; f < polygons_.size(); ++f) {
      const Polygon& polygon = polygons_[f];
      for (size_t k = 0; k < polygon.size(); ++k) {
        const dvec3 &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
        push(p);
        if (p.x == q.x && p.y == q.y) pushBetween(p, q, uprights[{p.x, p.y}], push);
      }
      model.face_ends.push_back(model.corners.size());
      model.face_materials.push_back(kNoIndex);
      model.face_colours.push_back(colours_[f]);
    }
    return model;
  }
  template <class Push>
  static void pushBetween(const dvec3& p, const dvec3& q, std::vector<double>& heights, const Push& push) {
    std::ranges::sort(heights);
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    std::vector<double> between;
    for (const double z : heights)
      if (z > std::min(p.z, q.z) && z < std::max(p.z, q.z)) between.push_back(z);
    if (q.z < p.z) std::ranges::reverse(between);
    for (const double z : between) push({p.x, p.y, z});
  }

  const std::vector<Part>& parts_;
  double bottom_m_;
  const Facade& facade_;
  std::vector<double> xs_, ys_;
  std::vector<Polygon> polygons_;
  std::vector<Colour> colours_;
};

}  // namespace

Model makeShell(const std::string& name, const std::vector<Part>& parts, double bottom_m, const Facade& facade) {
  return Shell(parts, bottom_m, facade).make(name);
}

}  // namespace foreland::terrain
