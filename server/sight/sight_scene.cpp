#include "server/sight/sight_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>
#include <string>
#include <utility>

#include "server/sight/sight_line.h"

namespace foreland::server {

namespace {

// A path that bends is cast in straight pieces that are at most so far off, for boxes are widened by it. The second is
// of the distance between samples: boxes stay small beside the blocks.
constexpr double kBend_m = 0.5, kBendOfSpacing = 0.05;
constexpr double kMaxPieces = 1 << 14;

using Surfaces = std::vector<std::unique_ptr<const ObjectSurface>>;

Surfaces surfacesOf(const SceneObjects& objects) {
  Surfaces surfaces(objects.set.models().size());
  for (const proto::ObjectPlacement& p : objects.set.placements())
    if (!surfaces[p.model]) surfaces[p.model] = std::make_unique<const ObjectSurface>(objects, p.model);
  return surfaces;
}

// Of an object's farthest point from its position, wherever the ground carries it.
double reachOf(const proto::ObjectPlacement& p, const ObjectSurface& surface) {
  const double diagonal = std::sqrt(3.0) * surface.reachMetres() * p.scale;
  return diagonal + glm::length(p.rise.quantum) * std::max(std::fabs(p.rise.range[0]), std::fabs(p.rise.range[1]));
}

// The body with all that stands on it: of its ground the tree knows nothing.
BoxTree::Space spaceOfGlobe(const Hierarchy& hierarchy, const Surfaces& surfaces) {
  BoxTree::Space space{.reach_m = hierarchy.frame().transform().frame().semi_major_m, .margin_m = kBend_m};
  for (const proto::ObjectPlacement& p : hierarchy.objects().set.placements())
    space.reach_m = std::max(space.reach_m, glm::length(p.position) + reachOf(p, *surfaces[p.model]));
  return space;
}

BoxTree::Space spaceOf(const Hierarchy& hierarchy, const Surfaces& surfaces) {
  const proto::GridShape& shape = hierarchy.grid().shape();
  const proto::FrameTransform& transform = hierarchy.frame().transform();
  if (shape.is_cube) return spaceOfGlobe(hierarchy, surfaces);
  const double x = shape.samples_x - 1, y = shape.samples_y - 1;
  const auto at = [&](double at_x, double at_y) { return transform.toScene(proto::LatticePosition{at_x, at_y, 0}); };
  BoxTree::Space space;
  space.origin = glm::round(at(0.5 * x, 0.5 * y));
  for (double at_x : {0.0, 0.5 * x, x})
    for (double at_y : {0.0, 0.5 * y, y})
      space.reach_m = std::max(space.reach_m, glm::distance(at(at_x, at_y), space.origin));
  for (const proto::ObjectPlacement& p : hierarchy.objects().set.placements())
    space.reach_m = std::max(space.reach_m, glm::distance(p.position, space.origin) + reachOf(p, *surfaces[p.model]));
  const terrain::HeightRange heights = hierarchy.scene().heightRange();
  const double highest = std::max(std::abs(double(heights.lowest)), std::abs(double(heights.highest)));
  // And the heights of other times, and what a sphere rises between the points taken.
  space.reach_m += (highest + hierarchy.maxOffset() * 2.0) * transform.frame().height_quantum_m + 0.1 * space.reach_m;
  space.margin_m = std::min(kBend_m, kBendOfSpacing * glm::distance(at(0.5 * x, 0.5 * y), at(0.5 * x + 1, 0.5 * y)));
  return space;
}

// Of heights that are held: of globes none.
uint64_t groundBytes(const proto::GridShape& shape) { return shape.is_cube ? 0 : GroundSurface::bytesFor(shape); }

Error tooLarge(uint64_t needed, uint64_t allowed) {
  return {ErrorCode::kLimit, "lines of sight over this scene take " + std::to_string(needed >> 20) +
                                 " MiB of memory, and may have " + std::to_string(allowed >> 20)};
}

}  // namespace

SightScene::SightScene(const Hierarchy& hierarchy, uint64_t tree_bytes)
    : hierarchy_(hierarchy),
      surfaces_(surfacesOf(hierarchy.objects())),
      space_(spaceOf(hierarchy, surfaces_)),
      tree_(space_, tree_bytes) {
  if (hierarchy.grid().isCube())
    triangles_.emplace(hierarchy);
  else
    ground_.emplace(hierarchy);
}

Result<std::shared_ptr<const SightScene>> SightScene::create(const Hierarchy& hierarchy, const SightOptions& options) {
  constexpr uint64_t kTreePerBlock = 96, kBytesPerNode = 40;  // about; a node has two triangles
  const proto::GridShape& shape = hierarchy.grid().shape();
  const uint64_t samples = shape.is_cube ? 0 : uint64_t{shape.samples_x} * shape.samples_y,
                 heights = groundBytes(shape);
  uint64_t needed = heights + samples / (GroundSurface::kBlock * GroundSurface::kBlock) * kTreePerBlock;
  for (const proto::ModelNodes& model : hierarchy.objects().nodes) needed += model.records.size() * kBytesPerNode;
  if (needed > options.max_bytes) return tooLarge(needed, options.max_bytes);
  std::shared_ptr<SightScene> scene(new SightScene(hierarchy, options.max_bytes - heights));
  SightScene& s = *scene;
  if (s.ground_) {
    const auto box_of = [&s](uint32_t block) { return s.ground_->boundsOf(block); };
    if (Status added = s.tree_.addBoxes(s.ground_->blocks(), box_of); !added.ok()) return added.error();
  }
  if (Status added = s.addObjects(); !added.ok()) return added.error();
  if (Status built = s.tree_.commit(); !built.ok()) return built.error();
  if (s.bytes() > options.max_bytes) return tooLarge(s.bytes(), options.max_bytes);
  return std::shared_ptr<const SightScene>(std::move(scene));
}

// Objects that stand still share a part, by model; one that the ground carries has boxes of its own, for all times.
Status SightScene::addObjects() {
  const SceneObjects& objects = hierarchy_.objects();
  const size_t models = objects.set.models().size();
  std::vector<double> smallest(models, std::numeric_limits<double>::infinity());
  for (const proto::ObjectPlacement& p : objects.set.placements())
    smallest[p.model] = std::min(smallest[p.model], p.scale);
  std::vector<std::optional<uint32_t>> still(models);
  for (const proto::ObjectPlacement& p : objects.set.placements()) {
    std::optional<uint32_t> part = p.rise.isStill() ? still[p.model] : std::nullopt;
    if (!part) {
      auto added = addPart(p.model, p.rise.isStill() ? smallest[p.model] : p.scale, p.rise.isStill() ? nullptr : &p);
      if (!added.ok()) return added.error();
      part = *added;
      if (p.rise.isStill()) still[p.model] = part;
    }
    if (Status s = tree_.addInstance(*part, glm::mat3_cast(p.orientation) * p.scale, p.position); !s.ok()) return s;
  }
  return {};
}

Result<uint32_t> SightScene::addPart(uint32_t model, double scale, const proto::ObjectPlacement* carried) {
  const ObjectSurface* surface = surfaces_[model].get();
  std::array<glm::dvec3, 2> rise{glm::dvec3(0), glm::dvec3(0)};
  if (carried != nullptr)
    for (size_t i = 0; i < 2; ++i)
      rise[i] = glm::inverse(carried->orientation) * (carried->rise.range[i] * carried->rise.quantum) / carried->scale;
  const auto box_of = [surface, rise](uint32_t group) {
    const Box box = surface->boundsOf(group);
    Box all;
    for (const glm::dvec3& r : rise) {
      all.add(box.low + r);
      all.add(box.high + r);
    }
    return all;
  };
  return tree_.addPart(surface->groups(), box_of, scale);
}

SightTime SightScene::at(std::optional<Time> scene_time) const {
  const proto::Epochs& epochs = hierarchy_.epochs().epochs();
  SightTime time;
  if (!epochs.empty()) time.ground = epochs.weightsAt(scene_time.value_or(epochs.last()));
  const proto::ObjectSet& set = hierarchy_.objects().set;
  for (size_t model = 0; model < set.models().size(); ++model)
    time.poses.push_back(set.posesOfModel(model).weightsAt(time.ground));
  for (const proto::ObjectPlacement& p : set.placements())
    time.positions.push_back(p.position + (p.rise.isStill() ? glm::dvec3(0) : p.rise.at(time.ground)));
  return time;
}

std::optional<glm::dvec3> SightScene::aboveGround(const glm::dvec2& lattice, double height_m,
                                                  const SightTime& time) const {
  const std::optional<glm::dvec3> ground = ground_ ? ground_->pointAt(lattice.x, lattice.y, time.ground)
                                                   : triangles_->pointAt(lattice.x, lattice.y, time.ground);
  if (!ground) return std::nullopt;
  return *ground + height_m * transform().upAt(*ground);
}

std::optional<glm::dvec3> SightScene::onZeroSurface(const glm::dvec2& lattice, double height_m) const {
  const proto::Frame& frame = transform().frame();
  const double latitude = frame.latitude0_rad + lattice.y * frame.latitude_step_rad;
  if (frame.kind == proto::FrameKind::kGeographic && !(std::fabs(latitude) <= std::numbers::pi / 2))
    return std::nullopt;
  const proto::GridShape& shape = hierarchy_.grid().shape();
  if (shape.is_cube &&
      !(lattice.x >= 0 && lattice.y >= 0 && lattice.x <= shape.samples_x - 1.0 && lattice.y <= shape.samples_y - 1.0))
    return std::nullopt;
  const glm::dvec3 at = transform().toScene(proto::LatticePosition{lattice.x, lattice.y, height_m});
  if (!(glm::length(at) <= kMaxReach_m)) return std::nullopt;
  return at;
}

// Of one line: what its boxes are asked.
struct SightScene::Question {
  const SightScene& scene;
  const SightLine& line;
  const SightTime& time;
  double first = 1;  // share before which it must be hidden; where it is once `is_hidden`
  bool is_hidden = false;
  int32_t object = SightHit::kGround;
  uint64_t work = 0;

  // Whether something in the box hides it before `first`.
  bool ask(int32_t instance, uint32_t box) {
    ++work;
    const double before = first;
    if (instance == BoxTree::kNoInstance) {
      if (const auto share = scene.ground_->meet(line, box, first, time.ground))
        first = *share, object = SightHit::kGround, is_hidden = true;
    } else {
      askObject(instance, box);
    }
    return first < before;
  }
  // The same of all the ground of a globe.
  void askGlobe(TriangleTree::Wanted wanted) {
    if (!scene.triangles_) return;
    if (const auto share = scene.triangles_->meet(line, wanted, first, time.ground, work))
      first = *share, is_hidden = true;
  }

  void askObject(int32_t instance, uint32_t group) {
    const auto number = static_cast<size_t>(instance);
    const proto::ObjectPlacement& placement = scene.hierarchy_.objects().set.placement(number);
    const glm::dmat3 turn = glm::mat3_cast(placement.orientation) * placement.scale;
    const auto take = [&](std::array<glm::dvec3, 3> corners) {
      for (glm::dvec3& corner : corners) corner = time.positions[number] + turn * corner;
      const auto share = line.meet(corners, {line.aside(corners[0]), line.aside(corners[1]), line.aside(corners[2])});
      if (share && *share < first) first = *share, object = instance, is_hidden = true;
    };
    scene.surfaces_[placement.model]->forEachTriangleOf(group, time.poses[placement.model], take);
  }
};

double SightScene::pieces(double sag_m) const {
  return std::clamp(std::ceil(std::sqrt(sag_m / space_.margin_m)), 1.0, kMaxPieces);
}

std::optional<SightHit> SightScene::firstHit(const glm::dvec3& from, const glm::dvec3& to, double refraction,
                                             const SightTime& time, uint64_t* work) const {
  const SightLine line(transform(), from, to, refraction);
  Question question{*this, line, time};
  question.askGlobe(TriangleTree::Wanted::kFirst);
  const double count = pieces(line.sagMetres());
  for (double i = 0; i < count && question.first > i / count; ++i) {
    const double begin = i / count, end = (i + 1) / count;
    tree_.castInOrder(line.at(begin), line.at(end), [&](int32_t instance, uint32_t box) {
      question.ask(instance, box);
      return (question.first - begin) * count;
    });
  }
  if (work != nullptr) *work += question.work;
  if (!question.is_hidden) return std::nullopt;
  return SightHit{question.first, line.at(question.first), question.object};
}

bool SightScene::sees(const glm::dvec3& from, const glm::dvec3& to, double refraction, const SightTime& time,
                      uint64_t* work) const {
  const SightLine line(transform(), from, to, refraction);
  Question question{*this, line, time};
  question.askGlobe(TriangleTree::Wanted::kAny);
  const double count = pieces(line.sagMetres());
  for (double i = 0; i < count && !question.is_hidden; ++i)
    tree_.cast(line.at(i / count), line.at((i + 1) / count),
               [&](int32_t instance, uint32_t box) { return question.ask(instance, box) ? -1.0 : 1.0; });
  if (work != nullptr) *work += question.work;
  return !question.is_hidden;
}

uint64_t SightScene::bytes() const {
  uint64_t bytes = tree_.bytes() + groundBytes(hierarchy_.grid().shape());
  for (const auto& surface : surfaces_)
    if (surface) bytes += surface->bytes();
  return bytes;
}

}  // namespace foreland::server
