// What a viewer asks its server beside the view: heights of the ground at full resolution, and what it says of where it
// is going. The conventions are those of exports.cpp.
#include <cstring>
#include <vector>

#include "client/wasm/conversions.h"
#include "client/wasm/host.h"

namespace foreland::client {
namespace {

constexpr size_t kPoseNumbers = 7;  // eye x, y, z; orientation x, y, z, w

std::vector<double> incomingNumbers() {
  std::vector<double> numbers(incoming().size() / sizeof(double));
  std::memcpy(numbers.data(), incoming().data(), numbers.size() * sizeof(double));
  return numbers;
}

}  // namespace

// Requests the ground at the lattice positions in the buffer, x and y each, at most proto::kMaxGroundPoints. Gives the
// id that the reply will have.
FORELAND_EXPORT(foreland_request_ground) uint32_t requestGround(Host* host) {
  const std::vector<double> numbers = incomingNumbers();
  std::vector<glm::dvec2> points(numbers.size() / 2);
  for (size_t i = 0; i < points.size(); ++i) points[i] = {numbers[2 * i], numbers[2 * i + 1]};
  return host->viewer.requestGround(std::move(points));
}

// The reply to that request, once; null if it has not arrived. Those to foreland_ground's own requests stay.
FORELAND_EXPORT(foreland_take_ground) const GroundRecord* takeGround(Host* host, uint32_t request) {
  std::optional<proto::GroundReply> reply = host->viewer.takeGround(request);
  if (!reply) return nullptr;
  host->ground_reply = std::move(reply);
  host->ground_record = {.id = host->ground_reply->id,
                         .count = static_cast<uint32_t>(host->ground_reply->heights_m.size()),
                         .heights_m = addressOf(host->ground_reply->heights_m.data()),
                         .undulations_m = host->ground_reply->undulations_m.empty()
                                              ? Address{0}
                                              : addressOf(host->ground_reply->undulations_m.data())};
  return &host->ground_record;
}

// Announces that the camera will take the poses in the buffer, seven numbers each, from a time on in even steps. 1 on
// success; 0 if that is no path (proto::Path::validate).
FORELAND_EXPORT(foreland_announce_path) uint32_t announcePath(Host* host, double start_ms, double step_ms) {
  const std::vector<double> n = incomingNumbers();
  proto::Path path{.start = timeOf(start_ms), .step = {timeOf(step_ms).us}, .poses = {}};
  for (size_t i = 0; i + kPoseNumbers <= n.size(); i += kPoseNumbers)
    path.poses.push_back(
        {.eye = {n[i], n[i + 1], n[i + 2]}, .orientation = glm::dquat(n[i + 6], n[i + 3], n[i + 4], n[i + 5])});
  if (!path.validate().ok()) return 0;
  host->viewer.announcePath(path);
  return 1;
}

}  // namespace foreland::client
