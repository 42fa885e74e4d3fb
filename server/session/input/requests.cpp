#include "server/session/input/requests.h"

#include <glm/vec2.hpp>
#include <limits>
#include <utility>

#include "proto/space/undulation_place.h"
#include "server/view/ground.h"
#include "server/view/tour.h"

namespace foreland::server {

namespace {

// Whole, at once.
Bytes replyTo(const proto::TourRequest& request, const Answering& with) {
  const auto path = with.tours.plan(request.name, request.seconds, with.now);
  return proto::encode(proto::TourReply{request.id, path->step, path->poses});
}

Bytes replyTo(const proto::GroundRequest& request, const terrain::Scene& scene) {
  proto::GroundReply reply{request.id, {}, {}};
  const proto::UndulationGrid& undulations = scene.vertical().undulations;
  reply.heights_m.reserve(request.positions.size());
  for (const glm::dvec2& p : request.positions)
    reply.heights_m.push_back(
        static_cast<float>(groundHeight(scene, p.x, p.y).value_or(std::numeric_limits<double>::quiet_NaN())));
  if (!undulations.isEmpty()) {
    const proto::FrameTransform transform(scene.frame());
    for (const glm::dvec2& p : request.positions)
      reply.undulations_m.push_back(static_cast<float>(undulations.at(proto::undulationPlace(transform, p))));
  }
  return proto::encode(reply);
}

size_t bytesOf(const proto::TourRequest& request) { return sizeof(request) + request.name.size(); }
size_t bytesOf(const proto::GroundRequest& request) {
  return sizeof(request) + request.positions.size() * sizeof(glm::dvec2);
}
size_t bytesOf(const SightWork& work) { return work.bytes(); }
size_t bytesOf(const ViewshedWork& work) { return work.bytes(); }

uint32_t idOf(const proto::TourRequest& request) { return request.id; }
uint32_t idOf(const proto::GroundRequest& request) { return request.id; }
uint32_t idOf(const SightWork& work) { return work.id(); }
uint32_t idOf(const ViewshedWork& work) { return work.id(); }

}  // namespace

size_t Requests::bytes() const {
  size_t sum = 0;
  for (const auto& request : waiting_) sum += std::visit([](const auto& r) { return bytesOf(r); }, request);
  return sum;
}

Status Requests::checkRoom() const {
  if (waiting_.size() < kMax) return {};
  return Error{ErrorCode::kLimit, "you ask for more than you read; wait for the replies to earlier requests"};
}

template <class Request>
void Requests::forget() {
  std::erase_if(waiting_, [](const auto& waits) { return std::holds_alternative<Request>(waits); });
}

Status Requests::add(const proto::TourRequest& request, const terrain::Scene& scene) {
  if (Status known = checkTour(scene, request.name); !known.ok()) return known;
  forget<proto::TourRequest>();
  if (Status room = checkRoom(); !room.ok()) return room;
  waiting_.emplace_back(request);
  return {};
}

Status Requests::add(const proto::GroundRequest& request) {
  if (Status room = checkRoom(); !room.ok()) return room;
  waiting_.emplace_back(request);
  return {};
}

Status Requests::add(const proto::SightRequest& request) {
  if (Status room = checkRoom(); !room.ok()) return room;
  waiting_.emplace_back(SightWork(request));
  return {};
}

Status Requests::add(const proto::ViewshedRequest& request) {
  forget<ViewshedWork>();
  if (Status room = checkRoom(); !room.ok()) return room;
  waiting_.emplace_back(ViewshedWork(request));
  return {};
}

void Requests::cancel(const proto::RequestCancel& request) {
  std::erase_if(waiting_, [&](const auto& waits) {
    return std::visit([](const auto& r) { return idOf(r); }, waits) == request.id;
  });
}

Duration Requests::patience() const {
  return std::holds_alternative<proto::TourRequest>(waiting_.front()) ? Duration::seconds(1)
                                                                      : Duration::milliseconds(200);
}

SightSlice Requests::answer(const Answering& with) {
  auto& oldest = waiting_.front();
  SightSlice answer{std::nullopt, true, false};
  if (auto* pairs = std::get_if<SightWork>(&oldest))
    answer = pairs->proceed(with.sight);
  else if (auto* viewshed = std::get_if<ViewshedWork>(&oldest))
    answer = viewshed->proceed(with.sight);
  else if (const auto* tour = std::get_if<proto::TourRequest>(&oldest))
    answer.message = replyTo(*tour, with);
  else
    answer.message = replyTo(std::get<proto::GroundRequest>(oldest), with.scene);
  if (answer.is_whole) waiting_.pop_front();
  return answer;
}

}  // namespace foreland::server
