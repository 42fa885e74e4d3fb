#include "bench/occlusion/judge.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>

#include "bench/occlusion/viewer_stream.h"
#include "bench/oracle/scene_truth.h"
#include "terrain/parallel.h"

namespace foreland::bench {

namespace {

using proto::NodeId;
using proto::Slot;

// The nodes of a keyframe that matter to visibility.
struct Sections {
  std::vector<Slot> without, withheld;  // ascending; the second are those of the first that are left out as hidden
};

Sections sectionsOf(const ViewerStream& without, const ViewerStream& with) {
  Sections sections{without.sender().adapter().section().slots, {}};
  for (Slot slot : sections.without)
    if (!with.sender().adapter().contains(slot)) sections.withheld.push_back(slot);
  return sections;
}

class NodeJudge {
 public:
  NodeJudge(const server::Hierarchy& hierarchy, const LineOfSight& terrain, const proto::Lens& lens)
      : hierarchy_(hierarchy), terrain_(terrain), lens_(lens) {}

  // Those of the nodes whose vertex can be seen, in whatever direction the camera looks.
  std::vector<Slot> visible(const std::vector<Slot>& slots, const glm::dvec3& eye) const {
    constexpr size_t kPiece = 1024;
    std::vector<uint8_t> is_visible(slots.size());
    terrain::parallelFor((slots.size() + kPiece - 1) / kPiece, 0,
                         [&](uint64_t piece, unsigned) {
                           const size_t end = std::min(slots.size(), (piece + 1) * kPiece);
                           for (size_t i = piece * kPiece; i < end; ++i)
                             is_visible[i] = isVisible(slots[i], eye) ? 1 : 0;
                         },
                         [](uint64_t) { return true; });
    std::vector<Slot> out;
    for (size_t i = 0; i < slots.size(); ++i)
      if (is_visible[i] != 0) out.push_back(slots[i]);
    return out;
  }

  // Those in the picture.
  std::vector<Slot> inPicture(const std::vector<Slot>& slots, const proto::Pose& pose) const {
    const double up = lens_.tanHalfFov(), aside = up * lens_.width_px / lens_.height_px;
    std::vector<Slot> out;
    for (Slot slot : slots) {
      const glm::dvec3 p = vertex(slot) - pose.eye;
      const double depth = glm::dot(p, pose.forward());
      if (std::fabs(glm::dot(p, pose.right())) < aside * depth && std::fabs(glm::dot(p, pose.up())) < up * depth)
        out.push_back(slot);
    }
    return out;
  }

  size_t closureSize(const std::vector<Slot>& slots) const {
    std::set<Slot> closure;
    std::vector<Slot> open = slots;
    while (!open.empty()) {
      const Slot slot = open.back();
      open.pop_back();
      if (!closure.insert(slot).second) continue;
      for (NodeId parent : grid().parents(grid().node(slot))) open.push_back(grid().slot(parent));
    }
    return closure.size();
  }

 private:
  const proto::GridTopology& grid() const { return hierarchy_.grid(); }
  glm::dvec3 vertex(Slot slot) const {
    return hierarchy_.frame().position(grid().node(slot), hierarchy_.nodes()[slot].height());
  }
  bool isVisible(Slot slot, const glm::dvec3& eye) const {
    const NodeId n = grid().node(slot);
    const proto::GridShape& shape = grid().shape();
    return n.x() < shape.samples_x && n.y() < shape.samples_y && terrain_.isClear(vertex(slot), eye);
  }

  const server::Hierarchy& hierarchy_;
  const LineOfSight& terrain_;
  proto::Lens lens_;
};

class Jury {
 public:
  Jury(const server::Hierarchy& hierarchy, const terrain::RayCaster& caster, const proto::Path& path,
       const FlightOptions& flight, const JudgeOptions& options)
      : path_(path),
        flight_(flight),
        options_(options),
        terrain_(truthOf(sceneOf(hierarchy))),
        nodes_(hierarchy, terrain_, flight.lens),
        pixels_(caster, terrain_) {}

  // The hierarchy outlives what is made of this.
  static std::shared_ptr<const terrain::Scene> sceneOf(const server::Hierarchy& hierarchy) {
    return {&hierarchy.scene(), [](const terrain::Scene*) {}};
  }

  // Which keyframes are judged.
  static std::vector<size_t> choose(size_t keyframes, const JudgeOptions& options) {
    std::set<size_t> chosen{0};
    for (size_t i = 0; i < options.keyframes && keyframes > 1; ++i)
      chosen.insert(1 + (2 * i + 1) * (keyframes - 1) / (2 * options.keyframes));
    return {chosen.begin(), chosen.end()};
  }

  void judgeNodes(const Sections& now, const Sections& before, size_t keyframe) {
    const proto::Pose pose = poseAt(static_cast<double>(keyframe));
    const std::vector<Slot> visible = nodes_.visible(now.without, pose.eye);
    const size_t closure = nodes_.closureSize(visible);
    judgement_.nodes += static_cast<double>(now.without.size());
    judgement_.visible_nodes += static_cast<double>(visible.size());
    judgement_.visible_closure += static_cast<double>(closure);
    if (keyframe == 0) {
      judgement_.first_nodes = judgement_.nodes;
      judgement_.first_visible_closure = judgement_.visible_closure;
    }
    const std::vector<Slot> withheld = nodes_.inPicture(both(visible, now.withheld), pose);
    judgement_.withheld_visible += withheld.size();
    if (keyframe == 0) return;
    const proto::Pose pose_before = poseAt(static_cast<double>(keyframe) - 1);
    judgement_.late_reveals +=
        nodes_.inPicture(nodes_.visible(both(withheld, before.withheld), pose_before.eye), pose_before).size();
  }

  Status judgePixels(const client::KeyframeMesh& with, const client::KeyframeMesh& without, size_t keyframe) {
    ++judgement_.judged_keyframes;
    if (Status s = judgePixels({with, without, 1}, static_cast<double>(keyframe), judgement_.keyframes); !s.ok())
      return s;
    if (keyframe == 0) return {};
    const double weight = nextWeight();
    ++judgement_.judged_frames;
    judgement_.least_weight = std::min(judgement_.least_weight, weight);
    judgement_.largest_weight = std::max(judgement_.largest_weight, weight);
    return judgePixels({with, without, weight}, static_cast<double>(keyframe) - 1 + weight, judgement_.frames);
  }

  const OcclusionJudgement& judgement() const { return judgement_; }

 private:
  static std::vector<Slot> both(const std::vector<Slot>& a, const std::vector<Slot>& b) {
    std::vector<Slot> out;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
    return out;
  }

  // The viewer's, whatever was predicted; `keyframe` counts intervals.
  proto::Pose poseAt(double keyframe) const {
    return path_.at(Time{} + Duration::seconds(keyframe * flight_.keyframe_interval.toSeconds()));
  }

  // Weights between keyframes: the middle of each of as many strata as frames are judged, in an order that has nothing
  // to do with the flight's (multiples of the golden ratio, rounded to strata).
  double nextWeight() {
    constexpr double kGolden = 0.6180339887498949;
    const double n = static_cast<double>(options_.keyframes), at = static_cast<double>(judgement_.judged_frames) + 0.5;
    return (std::floor(std::fmod(at * kGolden, 1.0) * n) + 0.5) / n;
  }

  Status judgePixels(const DrawnPair& drawn, double keyframe, PixelCounts& counts) {
    const auto judged = pixels_.judge(drawn, {poseAt(keyframe), flight_.lens}, flight_.tau_px);
    if (!judged) return judged.error();
    counts.add(*judged);
    return {};
  }

  const proto::Path& path_;
  const FlightOptions& flight_;
  const JudgeOptions& options_;
  LineOfSight terrain_;
  NodeJudge nodes_;
  PixelJudge pixels_;
  OcclusionJudgement judgement_;
};

}  // namespace

Result<OcclusionJudgement> judgeOcclusion(const server::Hierarchy& hierarchy, proto::BlockVisibility& visibility,
                                          const std::vector<proto::View>& views, const proto::Path& path,
                                          const FlightOptions& flight, const JudgeOptions& options) {
  const auto caster = terrain::RayCaster::ofScene(Jury::sceneOf(hierarchy));
  if (!caster) return caster.error();
  Jury jury(hierarchy, *caster, path, flight, options);
  ViewerStream without(hierarchy, nullptr), with(hierarchy, &visibility);
  const std::vector<size_t> judged = Jury::choose(views.size(), options);
  const auto isJudged = [&](size_t i) { return std::binary_search(judged.begin(), judged.end(), i); };
  Sections before;
  for (size_t i = 0; i <= judged.back(); ++i) {
    for (ViewerStream* stream : {&without, &with}) {
      stream->send(views[i], Time{} + flight.keyframe_interval * static_cast<int64_t>(i));
      stream->take();
    }
    if (!isJudged(i) && !isJudged(i + 1)) continue;
    Sections now = sectionsOf(without, with);
    if (isJudged(i)) {
      jury.judgeNodes(now, before, i);
      if (Status s = jury.judgePixels(with.replica().buildMesh(), without.replica().buildMesh(), i); !s.ok())
        return s.error();
    }
    before = std::move(now);
  }
  return jury.judgement();
}

}  // namespace foreland::bench
