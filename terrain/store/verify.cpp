#include "terrain/store/verify.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "proto/space/frame_grid.h"
#include "terrain/store/check_slots.h"
#include "terrain/store/file/faults.h"
#include "terrain/store/mapped_scene.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;

void checkSceneBlocks(const MappedScene& scene, unsigned threads, Faults& faults) {
  checkBlocks(scene.file(), scene.header().sections[kChecksums], threads, faults);
}

std::string name(NodeId n) { return "node (" + std::to_string(n.x()) + ", " + std::to_string(n.y()) + ")"; }

class NodeCheck {
 public:
  NodeCheck(const Scene& scene, Faults& faults)
      : scene_(scene), grid_(scene.grid()), positions_(scene.frame(), grid_.maxX(), grid_.maxY()), faults_(faults) {
    const proto::Epochs& epochs = scene.epochs().epochs();
    for (size_t i = 0; i < std::max<size_t>(epochs.size(), 1); ++i) {
      moments_.push_back({{static_cast<uint32_t>(i)}, {1}, 1});
      if (epochs.blend() != proto::EpochBlend::kLinear && i + 1 < epochs.size())
        moments_.push_back(epochs.weightsAt(epochs[i].time + Duration{(epochs[i + 1].time - epochs[i].time).us / 2}));
    }
  }

  // Whether the slot holds a node; otherwise it is padding.
  bool check(proto::Slot slot) const {
    const NodeRecord& record = scene_.nodes()[slot];
    const NodeId n = grid_.node(slot);
    const auto fault = [&](const std::string& what) { faults_.add(slot, what); };
    if (n == NodeId{}) {
      if (record != NodeRecord{}) fault("slot " + std::to_string(slot) + " is padding but not zero");
      return false;
    }
    if (!inRange(record.height())) fault(name(n) + " lies outside the scene's range of heights");
    const auto ends = grid_.endpoints(n);
    if (record.middle() != proto::middleOf(scene_.height(ends[0]), scene_.height(ends[1])))
      fault(name(n) + " has a displacement that is not from the middle of its edge");
    if ((slot + 1) % proto::kPageSlots != 0 && grid_.node(slot + 1) != NodeId{} &&
        scene_.nodes()[slot + 1].radius() != record.radius())
      fault(name(n) + " has another radius than its page");
    const glm::dvec3 centre = centreOf(n, record);
    const double radius = radiusOf(n, record);
    for (size_t i = 0; i < moments_.size(); ++i)
      if (i == 0 || mayMove(moments_[i], n)) checkBounds(n, record, centre, radius, moments_[i]);
    for (NodeId parent : grid_.parents(n))
      if (!scene_.pages().hasPage(grid_.slot(parent)))
        fault(name(n) + " is there, but the page of its parent " + name(parent) + " is not");
    for (NodeId child : grid_.children(n)) {
      if (!scene_.pages().hasPage(grid_.slot(child))) continue;
      const NodeRecord& below = scene_.node(child);
      if (below.error() > record.error()) fault(name(n) + " has a smaller error than its child " + name(child));
      if (glm::distance(centre, centreOf(child, below)) + radiusOf(child, below) > radius)
        fault(name(n) + " has a sphere that does not hold that of its child " + name(child));
    }
    return true;
  }

 private:
  glm::dvec3 centreOf(NodeId n, const NodeRecord& record) const { return positions_.position(n, record.middle()); }
  double radiusOf(NodeId n, const NodeRecord& record) const {
    return scene_.spheres().radius(grid_.level(n), record.radius());
  }
  bool inRange(int32_t height) const {
    return height >= scene_.heightRange().lowest && height <= scene_.heightRange().highest;
  }
  // Whether one of the vertices that a node's bounds are checked against may move by an epoch.
  bool mayMove(const proto::EpochWeights& moment, NodeId n) const {
    const auto moves = [&](NodeId v) {
      return std::ranges::any_of(moment.epochs(),
                                 [&](uint32_t epoch) { return scene_.epochs().epochs().mayMove(epoch, v); });
    };
    return moves(n) || std::ranges::any_of(grid_.endpoints(n), moves) || std::ranges::any_of(grid_.apexes(n), moves);
  }
  double heightAt(const proto::EpochWeights& moment, NodeId v) const {
    double height = scene_.height(v);
    for (uint32_t i = 0; i < moment.count; ++i)
      if (moment.epoch[i] > 0) height += moment.weight[i] * scene_.epochs().offset(moment.epoch[i], grid_, v);
    return height;
  }
  // Errors and spheres hold at all epochs, and between them.
  void checkBounds(NodeId n, const NodeRecord& record, const glm::dvec3& centre, double radius,
                   const proto::EpochWeights& moment) const {
    const auto checkCorner = [&](NodeId corner) {
      if (glm::distance(centre, positions_.position(corner, heightAt(moment, corner))) > radius)
        faults_.add(grid_.slot(n), name(n) + " has a sphere that does not hold its corners" + atMoment(moment));
    };
    std::ranges::for_each(grid_.endpoints(n), checkCorner);
    std::ranges::for_each(grid_.apexes(n), checkCorner);
    const double rounding_m = moment.count > 1 ? 1e-9 : 0;  // of weights, on heights of 10^5 m
    if (holdsItself(n) && record.error().metres() + rounding_m < displacement(n, moment))
      faults_.add(grid_.slot(n), name(n) + " has an error below its own displacement" + atMoment(moment));
  }
  static std::string atMoment(const proto::EpochWeights& moment) {
    if (moment.count > 1)
      return " between the epochs " + std::to_string(moment.epoch[0] + 1) + " and " +
             std::to_string(moment.epoch[moment.count - 1] + 1);
    return moment.epoch[0] == 0 ? "" : " at epoch " + std::to_string(moment.epoch[0] + 1);
  }
  bool holdsItself(NodeId n) const { return n.x() < grid_.shape().samples_x && n.y() < grid_.shape().samples_y; }
  // Distance of a node from the middle of its edge; in planar frames along the vertical, where it is exact.
  double displacement(NodeId n, const proto::EpochWeights& moment) const {
    const auto ends = grid_.endpoints(n);
    const double a = heightAt(moment, ends[0]), b = heightAt(moment, ends[1]), own = heightAt(moment, n);
    if (scene_.frame().kind == proto::FrameKind::kPlanar)
      return std::fabs(own - 0.5 * (a + b)) * scene_.frame().height_quantum_m;
    const glm::dvec3 middle = 0.5 * (positions_.position(ends[0], a) + positions_.position(ends[1], b));
    return glm::distance(positions_.position(n, own), middle);
  }

  const Scene& scene_;
  const proto::GridTopology& grid_;
  proto::FrameGrid positions_;
  std::vector<proto::EpochWeights> moments_;  // the first is the first epoch
  Faults& faults_;
};

uint64_t checkNodes(const Scene& scene, unsigned threads, Faults& faults) {
  const NodeCheck node(scene, faults);
  const proto::PageDirectory& pages = scene.pages();
  std::vector<proto::Slot> deep;  // first slots of the pages of sparse levels, by place
  for (const proto::PageBlock& block : pages.blocks())
    pages.forEachPage(block, [&](proto::Slot first, uint64_t) { deep.push_back(first); });
  return checkSlots(scene.records().size(), threads, [&](uint64_t place) {
    if (place < pages.wholeSlots()) return node.check(place);
    return node.check(deep[(place - pages.wholeSlots()) / proto::kPageSlots] + place % proto::kPageSlots);
  });
}

uint64_t checkBase(const Scene& scene, Faults& faults) {
  for (const auto& heights : {scene.cornerHeights(), scene.centreHeights()})
    for (int32_t height : heights)
      if (height < scene.heightRange().lowest || height > scene.heightRange().highest)
        faults.add(0, "a base vertex lies outside the scene's range of heights");
  return scene.cornerHeights().size() + scene.centreHeights().size();
}

void checkEpochs(const Scene& scene, Faults& faults) {
  scene.epochs().check(scene.grid(), [&](uint32_t epoch, const std::string& what) {
    faults.add(0, "epoch " + std::to_string(epoch + 1) + ": " + what);
  });
}

}  // namespace

Result<VerifyReport> verifyScene(const std::filesystem::path& path, unsigned threads) {
  const auto scene = MappedScene::open(path);
  if (!scene.ok()) return scene.error();
  Faults blocks, values;
  VerifyReport report;
  checkSceneBlocks(**scene, threads, blocks);
  report.blocks = blockCount((*scene)->header().sections[kChecksums]);
  report.base_vertices = checkBase(**scene, values);
  checkEpochs(**scene, values);
  report.nodes = checkNodes(**scene, threads, values);
  if (const CodedPages* coded = (*scene)->coded(); coded && coded->damagedGroups() > 0)
    values.add(0, "some coded pages are damaged, or larger than they should be");
  report.padding = (*scene)->records().size() - report.nodes;
  report.faults = blocks.count() + values.count();
  report.first_faults = blocks.first();
  for (const std::string& fault : values.first()) report.first_faults.push_back(fault);
  return report;
}

Result<std::shared_ptr<const Scene>> openVerified(const std::filesystem::path& path, unsigned threads,
                                                  uint64_t page_cache_bytes) {
  auto scene = MappedScene::open(path, page_cache_bytes);
  if (!scene.ok()) return scene.error();
  Faults faults;
  checkSceneBlocks(**scene, threads, faults);
  if (faults.count() == 0) return std::shared_ptr<const Scene>(std::move(*scene));
  return Error{ErrorCode::kMalformed,
               path.string() + ": " + faults.first().front() + "; build or copy the scene again"};
}

}  // namespace foreland::terrain
