#include "lab/occlusion/judge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>

#include "lab/occlusion/viewer_stream.h"
#include "oracle/reference/whole_mesh.h"
#include "oracle/scene_truth.h"
#include "terrain/parallel.h"

namespace foreland::lab {

namespace {

using proto::Slot;

// The nodes of a keyframe that matter to visibility.
struct Sections {
  std::vector<uint8_t> hidden_objects{};
  std::vector<Slot> without, withheld;  // ascending; the second are those of the first that are left out as hidden
};

Sections sectionsOf(const ViewerStream& without, const ViewerStream& with) {
  Sections sections{with.sender().hiddenObjectFlags(), without.sender().adapter().section().slots, {}};
  for (Slot slot : sections.without)
    if (!with.sender().adapter().contains(slot)) sections.withheld.push_back(slot);
  return sections;
}

// Those of the nodes whose vertex is in the picture.
std::vector<Slot> inPicture(const PossibleJudge& nodes, const std::vector<Slot>& slots, const proto::Pose& pose,
                            const proto::Lens& lens) {
  const double up = lens.tanHalfFov(), aside = up * lens.width_px / lens.height_px;
  std::vector<Slot> out;
  for (Slot slot : slots) {
    const glm::dvec3 p = nodes.vertex(slot) - pose.eye;
    const double depth = glm::dot(p, pose.forward());
    if (std::fabs(glm::dot(p, pose.right())) < aside * depth && std::fabs(glm::dot(p, pose.up())) < up * depth)
      out.push_back(slot);
  }
  return out;
}

class Jury {
 public:
  Jury(const server::Hierarchy& hierarchy, const terrain::RayCaster& caster, const proto::Path& path,
       const FlightOptions& flight, const JudgeOptions& options)
      : caster_(caster),
        has_objects_(hierarchy.objects().set.size() > 0),
        path_(path),
        flight_(flight),
        options_(options),
        terrain_(oracle::truthOf(sceneOf(hierarchy))),
        nodes_(hierarchy, terrain_),
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
    const auto at = static_cast<double>(keyframe);
    const PossibleNodes possible = nodes_.count(
        now.without, {poseAt(at), poseAt(std::max(0.0, at - 1)), poseAt(at + 1)}, flight_.lens, flight_.tau_px);
    judgement_.possible.add(possible);
    if (keyframe == 0) judgement_.first_possible = possible;
    judgement_.nodes_with += static_cast<double>(now.without.size() - now.withheld.size());
    const std::vector<Slot> withheld = seen(now.withheld, poseAt(at));
    judgement_.withheld_visible += withheld.size();
    if (keyframe > 0) judgement_.late_reveals += seen(both(withheld, before.withheld), poseAt(at - 1)).size();
  }

  // `hidden`: objects, at this keyframe and at the one before.
  Status judgePixels(const client::KeyframeMesh& with, const client::KeyframeMesh& without, size_t keyframe,
                     const std::vector<uint8_t>& hidden, const std::vector<uint8_t>& hidden_before) {
    ++judgement_.judged_keyframes;
    if (Status s = judgePixels({with, without, 1, hidden}, static_cast<double>(keyframe), judgement_.keyframes);
        !s.ok())
      return s;
    if (keyframe == 0) return {};
    const double weight = nextWeight();
    ++judgement_.judged_frames;
    judgement_.min_weight = std::min(judgement_.min_weight, weight);
    judgement_.largest_weight = std::max(judgement_.largest_weight, weight);
    std::vector<uint8_t> either = hidden;
    for (size_t i = 0; i < either.size() && i < hidden_before.size(); ++i) either[i] |= hidden_before[i];
    return judgePixels({with, without, weight, either}, static_cast<double>(keyframe) - 1 + weight, judgement_.frames);
  }

  const OcclusionJudgement& judgement() const { return judgement_; }

 private:
  // Those of the nodes whose vertex is in the picture and visible.
  std::vector<Slot> seen(const std::vector<Slot>& slots, const proto::Pose& pose) const {
    std::vector<Slot> seen = nodes_.visible(inPicture(nodes_, slots, pose, flight_.lens), pose.eye, flight_.lens, 0);
    if (has_objects_) std::erase_if(seen, [&](Slot slot) { return isBehindObject(nodes_.vertex(slot), pose.eye); });
    return seen;
  }
  bool isBehindObject(const glm::dvec3& vertex, const glm::dvec3& eye) const {
    constexpr double kNear_m = 0.05;  // more than floats round positions by
    const double distance = glm::distance(vertex, eye);
    const auto hit = caster_.hit({eye, (vertex - eye) / distance, std::max(0.0, distance - kNear_m)});
    return hit && hit->object != terrain::RayHit::kTerrain;
  }
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

  const terrain::RayCaster& caster_;
  const bool has_objects_;
  const proto::Path& path_;
  const FlightOptions& flight_;
  const JudgeOptions& options_;
  oracle::LineOfSight terrain_;
  PossibleJudge nodes_;
  PixelJudge pixels_;
  OcclusionJudgement judgement_;
};

}  // namespace

Result<OcclusionJudgement> judgeOcclusion(const server::Hierarchy& hierarchy, const Visibility& visibility,
                                          const std::vector<proto::View>& views, const proto::Path& path,
                                          const FlightOptions& flight, const JudgeOptions& options) {
  const auto caster = terrain::RayCaster::ofScene(Jury::sceneOf(hierarchy));
  if (!caster) return caster.error();
  Jury jury(hierarchy, *caster, path, flight, options);
  ViewerStream without(hierarchy, nullptr), with(hierarchy, &visibility.blocks, visibility.objects);
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
      if (Status s = jury.judgePixels(oracle::wholeMesh(with.replica()), oracle::wholeMesh(without.replica()), i,
                                      now.hidden_objects, before.hidden_objects);
          !s.ok())
        return s.error();
    }
    before = std::move(now);
  }
  return jury.judgement();
}

}  // namespace foreland::lab
