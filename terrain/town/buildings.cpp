#include "terrain/town/buildings.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "terrain/town/shell.h"

namespace foreland::terrain {

namespace {

using glm::dvec2;

constexpr Colour kTiles{150, 78, 58, 255}, kSlate{88, 92, 100, 255}, kGravel{150, 146, 140, 255},
    kCopper{96, 140, 124, 255};
constexpr Colour kPlaster{226, 214, 190, 255}, kOchre{214, 178, 120, 255}, kBrick{168, 110, 88, 255},
    kConcrete{186, 184, 180, 255}, kRose{218, 186, 172, 255}, kStone{176, 168, 152, 255}, kWhite{232, 230, 224, 255};

struct Rectangle {
  dvec2 low, high;
  double depthAt(const dvec2& p) const { return std::min({p.x - low.x, high.x - p.x, p.y - low.y, high.y - p.y}); }
};

Rectangle aboutOrigin(double width, double depth) { return {{-width / 2, -depth / 2}, {width / 2, depth / 2}}; }

Part flat(const Rectangle& r, double height, const Colour& wall, const Colour& roof) {
  return {r.low, r.high, [=](const dvec2&) { return height; }, {}, {}, wall, roof};
}

enum class Ridge : uint8_t { kAlongX, kAlongY };
Part gable(const Rectangle& r, Ridge ridge, double eaves, double slope, const Colour& wall, const Colour& roof) {
  const bool along_x = ridge == Ridge::kAlongX;
  const dvec2 middle = (r.low + r.high) / 2.0;
  const auto height = [=](const dvec2& p) {
    return eaves +
           slope * (along_x ? std::min(p.y - r.low.y, r.high.y - p.y) : std::min(p.x - r.low.x, r.high.x - p.x));
  };
  Part part{r.low, r.high, height, {}, {}, wall, roof};
  (along_x ? part.ys : part.xs).push_back(along_x ? middle.y : middle.x);
  return part;
}

// Bends `inset` from the sides, where it becomes flat or, by `upper`, less steep up to the middle.
Part hipped(const Rectangle& r, double eaves, double slope, double inset, double upper, const Colour& wall,
            const Colour& roof) {
  const dvec2 size = r.high - r.low;
  const double most = std::min(size.x, size.y) / 2;
  const auto height = [=](const dvec2& p) {
    const double depth = r.depthAt(p);
    return eaves + slope * std::min(depth, inset) + upper * std::max(0.0, depth - inset);
  };
  Part part{r.low, r.high, height, {}, {}, wall, roof};
  for (const double line : {inset, most}) {
    part.xs.insert(part.xs.end(), {r.low.x + line, r.high.x - line});
    part.ys.insert(part.ys.end(), {r.low.y + line, r.high.y - line});
  }
  return part;
}
Part hipped(const Rectangle& r, double eaves, double slope, const Colour& wall, const Colour& roof) {
  const dvec2 size = r.high - r.low;
  return hipped(r, eaves, slope, std::min(size.x, size.y) / 2, 0, wall, roof);
}

// Two wings as deep as `wing` along the low sides of a square, under one hipped roof, or a flat one.
std::vector<Part> corner(double side, double wing, double eaves, double slope, const Colour& wall, const Colour& roof) {
  const Rectangle square = aboutOrigin(side, side);
  const Rectangle along{square.low, {square.high.x, square.low.y + wing}},
      up{square.low, {square.low.x + wing, square.high.y}};
  const auto height = [=](const dvec2& p) { return eaves + slope * std::max({0.0, along.depthAt(p), up.depthAt(p)}); };
  std::vector<Part> parts;
  for (const Rectangle& r : {along, up}) {
    Part part{r.low, r.high, height, {}, {}, wall, roof};
    for (const double line : {square.low.x + wing / 2, along.high.x - wing / 2}) part.xs.push_back(line);
    for (const double line : {square.low.y + wing / 2, up.high.y - wing / 2}) part.ys.push_back(line);
    part.xs.push_back(square.low.x + wing), part.ys.push_back(square.low.y + wing);
    parts.push_back(std::move(part));
  }
  return parts;
}

Part chimney(const dvec2& at, double top) {
  Part part = flat({at - 0.5, at + 0.5}, top, kBrick, kSlate);
  part.has_windows = false;
  return part;
}

std::vector<Part> church() {
  Part nave = gable({{-7, -12}, {7, 18}}, Ridge::kAlongY, 10, 1.1, kStone, kSlate);
  Part choir = gable({{-4.5, 18}, {4.5, 24}}, Ridge::kAlongY, 8, 1.1, kStone, kSlate);
  Part tower = hipped({{-4, -19}, {4, -11}}, 25, 3, kStone, kCopper);
  nave.has_windows = choir.has_windows = tower.has_windows = false;
  return {std::move(nave), std::move(choir), std::move(tower)};
}
std::vector<Part> tower() {
  return {flat(aboutOrigin(14, 14), 9, kStone, kGravel), flat(aboutOrigin(9, 9), 34, kStone, kGravel),
          hipped(aboutOrigin(6.5, 6.5), 38, 2.6, kStone, kCopper)};
}

Building build(std::string name, BuildingUse use, const std::vector<Part>& parts, const Facade& facade = {}) {
  Building building{std::move(name), use, {}, 0, {}};
  building.model = makeShell(building.name, parts, -kFoundation_m, facade);
  dvec2 low(0), high(0);
  for (const glm::dvec3& p : building.model.positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)}, high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    building.height = std::max(building.height, p.z);
  }
  building.size = high - low;
  return building;
}

}  // namespace

std::vector<Building> makeBuildings() {
  const auto house = [](std::string name, std::vector<Part> parts, const Facade& facade = {}) {
    return build(std::move(name), BuildingUse::kHouse, parts, facade);
  };
  const auto angle = [](std::string name, std::vector<Part> parts, const Facade& facade = {}) {
    return build(std::move(name), BuildingUse::kCorner, parts, facade);
  };
  const Facade offices{.storey_m = 3.6, .sill_m = 0.9, .window_m = 2.2, .pitch_m = 3.4, .width_m = 2.4};
  std::vector<Building> all;
  all.push_back(house("cottage", {hipped(aboutOrigin(10, 10), 5.2, 0.8, kWhite, kTiles)}));
  all.push_back(house("gable-across", {gable(aboutOrigin(9, 12), Ridge::kAlongY, 8.4, 1.1, kOchre, kTiles)}));
  all.push_back(house("gable-along", {gable(aboutOrigin(14, 11), Ridge::kAlongX, 8.4, 0.9, kPlaster, kTiles),
                                      chimney({3.5, 2}, 13.6)}));
  all.push_back(house("gable-tall", {gable(aboutOrigin(12, 12), Ridge::kAlongX, 11.6, 1.0, kRose, kSlate)}));
  all.push_back(house("row", {gable(aboutOrigin(28, 11), Ridge::kAlongX, 8.4, 0.8, kBrick, kTiles)}));
  all.push_back(house("villa", {hipped(aboutOrigin(18, 13), 11.6, 0.75, kPlaster, kSlate)}));
  all.push_back(house("mansard", {hipped(aboutOrigin(16, 14), 11.6, 2.0, 1.8, 0.25, kOchre, kSlate)}));
  all.push_back(house("flats", {flat(aboutOrigin(24, 14), 19.2, kConcrete, kGravel)}));
  all.push_back(house(
      "stepped", {flat(aboutOrigin(20, 16), 16.1, kWhite, kGravel), flat({{-7, -5}, {7, 5}}, 19.2, kWhite, kGravel)}));
  all.push_back(house("offices", {flat(aboutOrigin(22, 18), 27.6, kStone, kGravel)}, offices));
  all.push_back(angle("corner-hipped", corner(24, 11, 11.6, 0.85, kRose, kTiles)));
  all.push_back(angle("corner-flat", corner(26, 13, 20.2, 0, kPlaster, kGravel)));
  all.push_back(build("church", BuildingUse::kChurch, church()));
  all.push_back(build("tower", BuildingUse::kTower, tower()));
  return all;
}

}  // namespace foreland::terrain
