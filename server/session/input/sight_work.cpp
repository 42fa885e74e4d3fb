#include "server/session/input/sight_work.h"

#include <limits>
#include <utility>

namespace foreland::server {

namespace {

// Blocks of ground and groups of triangles, a third of a microsecond each; and cells, of which many may need none.
constexpr uint64_t kSliceWork = 12'000;
constexpr size_t kSlicePairs = 1024;
constexpr uint32_t kSliceCells = 8192;

}  // namespace

size_t SightWork::bytes() const {
  return sizeof(*this) + (request_.ends.size() + reply_.ends.size()) * sizeof(glm::dvec3) +
         reply_.hits.size() * sizeof(proto::SightHit);
}

SightSlice SightWork::proceed(SightSupply& supply) {
  const auto scene = supply.ask();
  if (!scene.ok()) {
    const proto::SightReply refusal{request_.id, scene.error().message, {}, {}};
    return {proto::encode(refusal), true, false};
  }
  if (*scene == nullptr) return {std::nullopt, false, true};
  if (!time_) time_ = (*scene)->at(request_.scene_time);
  uint64_t work = 0;
  for (size_t i = 0; i < kSlicePairs && work < kSliceWork && reply_.ends.size() < request_.ends.size(); ++i)
    ask(**scene, reply_.hits.size(), work);
  if (reply_.ends.size() < request_.ends.size()) return {};
  return {proto::encode(reply_), true, false};
}

void SightWork::ask(const SightScene& scene, size_t pair, uint64_t& work) {
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  proto::SightHit hit;
  for (size_t i = 2 * pair; i < 2 * pair + 2; ++i) {
    const glm::dvec3& end = request_.ends[i];
    std::optional<glm::dvec3> at;
    if (request_.above == proto::Above::kGround)
      at = scene.aboveGround({end.x, end.y}, end.z, *time_);
    else
      at = scene.onZeroSurface({end.x, end.y}, end.z);
    if (!at) hit.what = proto::SightHit::kUnknown;
    reply_.ends.push_back(at.value_or(glm::dvec3(kNowhere)));
  }
  if (hit.what != proto::SightHit::kUnknown)
    if (const auto found =
            scene.firstHit(reply_.ends[2 * pair], reply_.ends[2 * pair + 1], request_.refraction, *time_, &work))
      hit = {found->position, found->object};
  reply_.hits.push_back(hit);
}

SightSlice ViewshedWork::refuse(const Error& error) const {
  proto::ViewshedReply refusal;
  refusal.id = request_.id;
  refusal.error = error.message;
  return {proto::encode(refusal), true, false};
}

SightSlice ViewshedWork::proceed(SightSupply& supply) {
  if (!viewshed_) {
    auto scene = supply.ask();
    if (!scene.ok()) return refuse(scene.error());
    if (*scene == nullptr) return {std::nullopt, false, true};
    if (Status s = begin(std::move(*scene)); !s.ok()) return refuse(s.error());
  }
  return tell();
}

Status ViewshedWork::begin(std::shared_ptr<const SightScene> scene) {
  const ViewshedQuestion question{request_.observer, request_.observer_m, request_.target_m,  request_.radius_m,
                                  request_.cell_m,   request_.refraction, request_.scene_time};
  auto grid = Viewshed::gridOf(scene->hierarchy(), question, proto::kMaxViewshedCells);
  if (!grid.ok()) return grid.error();
  viewshed_.emplace(std::move(scene), question, *grid);
  return {};
}

SightSlice ViewshedWork::tell() {
  const ViewshedGrid& grid = viewshed_->grid();
  proto::ViewshedReply reply{request_.id, {}, grid.first, grid.step, grid.columns, grid.rows, told_, {}};
  const uint64_t cells = grid.cells();
  for (uint64_t work = 0; work < kSliceWork && told_ < cells && reply.cells.size() < kSliceCells; ++told_)
    reply.cells.push_back(viewshed_->cell(told_ % grid.columns, told_ / grid.columns, &work));
  return {proto::encode(reply), told_ == cells, false};
}

}  // namespace foreland::server
