// Exports about what is seen (proto/message/sight_message.h): requests go through a viewer, replies are read from their
// bytes by whichever thread shows them. Numbers cross as rows of doubles.
#include <cstring>
#include <string>
#include <vector>

#include "client/wasm/conversions.h"
#include "client/wasm/host.h"
#include "client/wasm/record_layout.h"

namespace foreland::client {
namespace {

struct Reply {
  std::vector<double> numbers;
  std::string error;
  TextRecord numbers_record{}, error_record{};
};
Reply& reply() {
  static Reply last;
  return last;
}

const TextRecord* tell(std::vector<double> numbers, const std::string& error) {
  Reply& r = reply();
  r.numbers = std::move(numbers);
  r.error = error;
  r.numbers_record = {addressOf(r.numbers.data()), static_cast<uint32_t>(r.numbers.size() * sizeof(double))};
  return &r.numbers_record;
}

void add(std::vector<double>& numbers, const glm::dvec3& v) { numbers.insert(numbers.end(), {v.x, v.y, v.z}); }

}  // namespace

// Of the pairs of ends in the buffer, six doubles each. Gives the number that the reply will have.
FORELAND_EXPORT(foreland_request_sight)
uint32_t requestSight(Host* host, uint32_t above, double refraction, double scene_ms) {
  proto::SightRequest request;
  request.ends.resize(incoming().size() / sizeof(glm::dvec3));
  std::memcpy(static_cast<void*>(request.ends.data()), incoming().data(), request.ends.size() * sizeof(glm::dvec3));
  request.above = above == 0 ? proto::Above::kGround : proto::Above::kZeroSurface;
  request.refraction = refraction;
  request.scene_time = timeOf(scene_ms);
  return host->viewer.requestSight(std::move(request));
}

FORELAND_EXPORT(foreland_request_viewshed)
uint32_t requestViewshed(Host* host, double x, double y, double observer_m, double target_m, double radius_m,
                         double cell_m, double refraction, double scene_ms) {
  return host->viewer.requestViewshed(
      {0, {x, y}, observer_m, target_m, radius_m, cell_m, refraction, timeOf(scene_ms)});
}

FORELAND_EXPORT(foreland_cancel_request) void cancelRequest(Host* host, uint32_t id) { host->viewer.cancelRequest(id); }

// Whether such a reply has arrived, which foreland_read_sight reads from its bytes: 1 of lines of sight, 2 of a
// viewshed.
FORELAND_EXPORT(foreland_take_sight) uint32_t takeSight(Host* host) {
  if (host->viewer.takeSight()) return 1;
  return host->viewer.takeViewshed() ? 2 : 0;
}

// Reads the reply in the buffer. Of lines of sight: its number; for each pair both ends, the first point that hides,
// and what does (SightHit::what). Of a viewshed: its number, first and step, columns, rows, begin, then a number for
// each cell. Null if it is neither.
FORELAND_EXPORT(foreland_read_sight) const TextRecord* readSight() {
  const auto message = proto::decodeServerMessage(incoming());
  if (!message) return nullptr;
  if (const auto* sight = std::get_if<proto::SightReply>(&*message)) {
    std::vector<double> numbers{double(sight->id)};
    for (size_t i = 0; i < sight->hits.size(); ++i) {
      add(numbers, sight->ends[2 * i]);
      add(numbers, sight->ends[2 * i + 1]);
      add(numbers, sight->hits[i].position);
      numbers.push_back(sight->hits[i].what);
    }
    return tell(std::move(numbers), sight->error);
  }
  const auto* viewshed = std::get_if<proto::ViewshedReply>(&*message);
  if (viewshed == nullptr) return nullptr;
  const proto::ViewshedReply& v = *viewshed;
  std::vector<double> numbers{double(v.id), v.first.x,         v.first.y,      v.step.x,
                              v.step.y,     double(v.columns), double(v.rows), double(v.begin)};
  for (const proto::ViewshedCell cell : v.cells) numbers.push_back(static_cast<double>(cell));
  return tell(std::move(numbers), v.error);
}

// Why the reply that was read last holds no answer; empty if it does.
FORELAND_EXPORT(foreland_sight_error) const TextRecord* sightError() {
  Reply& r = reply();
  r.error_record = {addressOf(r.error.data()), static_cast<uint32_t>(r.error.size())};
  return &r.error_record;
}

}  // namespace foreland::client
