#include "server/session/input/requests.h"

#include <glm/vec2.hpp>
#include <limits>
#include <utility>

#include "server/view/ground.h"
#include "server/view/tour.h"

namespace foreland::server {

namespace {

Bytes replyTo(const proto::TourRequest& request, const terrain::Scene& scene) {
  auto path = planTour(scene, request.name, request.seconds).value();
  return proto::encode(proto::TourReply{request.id, path.step, std::move(path.poses)});
}

Bytes replyTo(const proto::GroundRequest& request, const terrain::Scene& scene) {
  proto::GroundReply reply{request.id, {}};
  reply.heights_m.reserve(request.positions.size());
  for (const glm::dvec2& p : request.positions)
    reply.heights_m.push_back(
        static_cast<float>(groundHeight(scene, p.x, p.y).value_or(std::numeric_limits<double>::quiet_NaN())));
  return proto::encode(reply);
}

size_t bytesOf(const proto::TourRequest& request) { return sizeof(request) + request.name.size(); }
size_t bytesOf(const proto::GroundRequest& request) {
  return sizeof(request) + request.positions.size() * sizeof(glm::dvec2);
}

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

Status Requests::add(const proto::TourRequest& request) {
  if (Status known = checkTour(request.name); !known.ok()) return known;
  std::erase_if(waiting_, [](const auto& waits) { return std::holds_alternative<proto::TourRequest>(waits); });
  if (Status room = checkRoom(); !room.ok()) return room;
  waiting_.emplace_back(request);
  return {};
}

Status Requests::add(const proto::GroundRequest& request) {
  if (Status room = checkRoom(); !room.ok()) return room;
  waiting_.emplace_back(request);
  return {};
}

Bytes Requests::answer(const terrain::Scene& scene) {
  Bytes reply = std::visit([&](const auto& request) { return replyTo(request, scene); }, waiting_.front());
  waiting_.pop_front();
  return reply;
}

}  // namespace foreland::server
