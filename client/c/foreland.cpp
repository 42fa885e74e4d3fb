// The functions of foreland.h about a terrain and its frames: they check and convert, and leave the rest to
// client/c/terrain.h. Those about places and questions are in queries.cpp.
#include "client/c/foreland.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "client/c/calls.h"

namespace foreland::client {
namespace {

Time timeOf(double ms) { return {std::llround(ms * 1000)}; }
bool isTime(double ms) { return std::abs(ms) < 1e15; }

proto::Pose poseOf(const ForelandPose& pose) {
  const double* q = pose.orientation;
  return {.eye = {pose.eye[0], pose.eye[1], pose.eye[2]}, .orientation = glm::dquat(q[3], q[0], q[1], q[2])};
}

ForelandChannel channelOf(const ChannelUpdate& channel) {
  static_assert(sizeof(Range) == 2 * sizeof(uint32_t));
  return {.data = channel.data.data(),
          .ranges = reinterpret_cast<const uint32_t*>(channel.ranges.data()),
          .range_count = static_cast<uint32_t>(channel.ranges.size()),
          .count = channel.count};
}

ForelandPart partOf(const PartUpdate& part) {
  return {.is_whole = part.is_whole ? 1u : 0u,
          .triangle_count = part.triangles,
          .from_positions = channelOf(part.from_positions),
          .to_positions = channelOf(part.to_positions),
          .from_normals = channelOf(part.from_normals),
          .to_normals = channelOf(part.to_normals),
          .from_moved = channelOf(part.from_moved),
          .to_moved = channelOf(part.to_moved),
          .from_bends = channelOf(part.from_bends),
          .to_bends = channelOf(part.to_bends),
          .parameters = channelOf(part.parameters),
          .triangles = channelOf(part.indices)};
}

ForelandUpdate updateOf(const MeshUpdate& update) {
  static_assert(sizeof(ObjectPart) == sizeof(ForelandObjectPart));
  const proto::Pose& pose = update.interval.to.pose;
  const glm::dquat& q = pose.orientation;
  return {.size = sizeof(ForelandUpdate),
          .version = update.interval.version,
          .oldest_version = update.oldest_version,
          .object_part_count = static_cast<uint32_t>(update.object_parts.size()),
          .object_parts = reinterpret_cast<const ForelandObjectPart*>(update.object_parts.data()),
          .origin = {update.origin.x, update.origin.y, update.origin.z},
          .to_time = static_cast<double>(update.interval.to.time.us) / 1000,
          .to_pose = {{pose.eye.x, pose.eye.y, pose.eye.z}, {q.x, q.y, q.z, q.w}},
          .terrain = partOf(update.terrain),
          .objects = partOf(update.objects)};
}

ForelandStatus open(const char* server, const ForelandOptions* options, ForelandTerrain** out) {
  if (options != nullptr && !hasSize(options)) return refuse(FORELAND_ARGUMENT, kNoSize);
  const auto url = parseWebSocketUrl(server);
  if (!url.ok()) return refuse(url.error());
  Choice choice;
  if (options != nullptr) choice.options = readStruct(*options);
  const auto textOf = [](const char* text) { return std::string(text != nullptr ? text : ""); };
  WebSocketClient::Options connection{.token = textOf(choice.options.token),
                                      .ca_file = textOf(choice.options.ca_file),
                                      .token_advice = "give a valid token by foreland_set_token",
                                      .ca_advice = "ForelandOptions.ca_file names the authority",
                                      .stop = {}};
  if (const auto blend = blendOf(choice.options); !blend.ok()) return refuse(blend.error());
  if (const auto request = requestOf(choice); !request.ok()) return refuse(request.error());
  *out = new ForelandTerrain{Terrain(server, std::move(connection), choice)};
  return FORELAND_OK;
}

}  // namespace
}  // namespace foreland::client

using namespace foreland;          // NOLINT: the functions below are C's
using namespace foreland::client;  // NOLINT

// NOLINTBEGIN(readability-identifier-naming): C's names

uint32_t foreland_abi(void) { return FORELAND_ABI; }
const char* foreland_version(void) { return FORELAND_VERSION; }
double foreland_now(void) { return static_cast<double>(sessionNow().us) / 1000; }
const char* foreland_last_error(void) { return lastError(); }

ForelandStatus foreland_open(const char* server, const ForelandOptions* options, ForelandTerrain** out) {
  if (server == nullptr || out == nullptr) return refuse(FORELAND_ARGUMENT, kNoTerrain);
  return guarded([&] { return open(server, options, out); });
}

void foreland_close(ForelandTerrain* terrain) { delete terrain; }

ForelandStatus foreland_next_event(ForelandTerrain* terrain, ForelandEvent* out) {
  const auto work = [&](Terrain& t) {
    if (!hasSize(out)) return refuse(FORELAND_ARGUMENT, kNoSize);
    const ForelandEvent* event = t.nextEvent();
    if (event == nullptr) return refuse(FORELAND_NOTHING, "Nothing has happened.");
    writeStruct(*event, out);
    return ForelandStatus{FORELAND_OK};
  };
  return withTerrain(terrain, work, out);
}

ForelandStatus foreland_wait(ForelandTerrain* terrain, double milliseconds) {
  return withTerrain(terrain, [&](Terrain& t) -> ForelandStatus {
    if (!(milliseconds >= 0 && milliseconds < 1e12))
      return refuse(FORELAND_ARGUMENT, "Wait for 0 milliseconds or more.");
    return t.wait(milliseconds) ? FORELAND_OK : refuse(FORELAND_NOTHING, "Nothing has come in that time.");
  });
}

ForelandStatus foreland_get_scene(ForelandTerrain* terrain, ForelandScene* out) {
  const auto work = [&](Terrain& t) {
    if (!hasSize(out)) return refuse(FORELAND_ARGUMENT, kNoSize);
    writeStruct(t.scene(), out);
    return ForelandStatus{FORELAND_OK};
  };
  return withScene(terrain, work, out);
}

ForelandStatus foreland_get_stats(ForelandTerrain* terrain, ForelandStats* out) {
  const auto work = [&](Terrain& t) {
    if (!hasSize(out)) return refuse(FORELAND_ARGUMENT, kNoSize);
    t.receive();
    writeStruct(t.stats(), out);
    return ForelandStatus{FORELAND_OK};
  };
  return withTerrain(terrain, work, out);
}

ForelandStatus foreland_set_lens(ForelandTerrain* terrain, const ForelandLens* lens) {
  const auto work = [&](Terrain& t) {
    if (!hasSize(lens)) return refuse(FORELAND_ARGUMENT, kNoSize);
    return statusOf(t.setLens(readStruct(*lens)));
  };
  return withTerrain(terrain, work, lens);
}

ForelandStatus foreland_set_options(ForelandTerrain* terrain, const ForelandOptions* options) {
  const auto work = [&](Terrain& t) {
    if (!hasSize(options)) return refuse(FORELAND_ARGUMENT, kNoSize);
    return statusOf(t.setOptions(readStruct(*options)));
  };
  return withTerrain(terrain, work, options);
}

ForelandStatus foreland_set_scene_time(ForelandTerrain* terrain, double at, double rate) {
  return withTerrain(terrain, [&](Terrain& t) -> ForelandStatus {
    if (!isTime(at)) return refuse(FORELAND_ARGUMENT, "The scene time is not a time.");
    return statusOf(t.setSceneClock({sessionNow(), timeOf(at), rate}));
  });
}

ForelandStatus foreland_set_token(ForelandTerrain* terrain, const char* token) {
  return withTerrain(terrain, [&](Terrain& t) -> ForelandStatus {
    t.tell(told::Token{token != nullptr ? token : ""});
    return FORELAND_OK;
  });
}

ForelandStatus foreland_reconnect(ForelandTerrain* terrain) {
  return withTerrain(terrain, [](Terrain& t) -> ForelandStatus {
    t.tell(told::Reconnect{});
    return FORELAND_OK;
  });
}

ForelandStatus foreland_set_seen(ForelandTerrain* terrain, int32_t is_seen) {
  return withTerrain(terrain, [&](Terrain& t) -> ForelandStatus {
    t.tell(told::Seen{is_seen != 0});
    return FORELAND_OK;
  });
}

ForelandStatus foreland_frame(ForelandTerrain* terrain, double now, const ForelandPose* pose, ForelandFrame* out) {
  const auto work = [&](Terrain& t) {
    if (!hasSize(out)) return refuse(FORELAND_ARGUMENT, kNoSize);
    const proto::Pose camera = poseOf(*pose);
    if (!isTime(now)) return refuse(FORELAND_ARGUMENT, "The time of the frame is not one of foreland_now().");
    if (!proto::isUsable(camera))
      return refuse(FORELAND_ARGUMENT,
                    "The pose is not finite, more than 1e8 m away, or its orientation is not of length 1.");
    writeStruct(t.frame(timeOf(now), camera), out);
    return ForelandStatus{FORELAND_OK};
  };
  return withTerrain(terrain, work, pose, out);
}

ForelandStatus foreland_next_update(ForelandTerrain* terrain, ForelandUpdate* out) {
  const auto work = [&](Terrain& t) {
    if (!hasSize(out)) return refuse(FORELAND_ARGUMENT, kNoSize);
    const MeshUpdate* update = t.nextUpdate();
    if (update == nullptr) return refuse(FORELAND_NOTHING, "No other mesh has come.");
    writeStruct(updateOf(*update), out);
    return ForelandStatus{FORELAND_OK};
  };
  return withTerrain(terrain, work, out);
}

ForelandStatus foreland_set_ready(ForelandTerrain* terrain, uint32_t ready, uint32_t coming) {
  return withTerrain(terrain, [&](Terrain& t) -> ForelandStatus {
    t.setReady(ready, coming);
    return FORELAND_OK;
  });
}

ForelandStatus foreland_redraw(ForelandTerrain* terrain) {
  return withTerrain(terrain, [](Terrain& t) -> ForelandStatus {
    t.redraw();
    return FORELAND_OK;
  });
}

ForelandStatus foreland_jump(ForelandTerrain* terrain) {
  return withTerrain(terrain, [](Terrain& t) -> ForelandStatus {
    t.jump();
    return FORELAND_OK;
  });
}

ForelandStatus foreland_announce_path(ForelandTerrain* terrain, const ForelandPose* poses, uint32_t count, double start,
                                      double step) {
  return withTerrain(terrain, [&](Terrain& t) -> ForelandStatus {
    if (poses == nullptr && count > 0) return refuse(FORELAND_ARGUMENT, kNoTerrain);
    if (count > proto::Path::kMaxPoses || !isTime(start) || !isTime(step))
      return refuse(FORELAND_ARGUMENT, "A path has 2 to 100,000 poses in steps of 1 ms to 60 s.");
    proto::Path path{.start = timeOf(start), .step = {timeOf(step).us}, .poses = {}};
    std::transform(poses, poses + count, std::back_inserter(path.poses), poseOf);
    return statusOf(t.announcePath(std::move(path)));
  });
}

// NOLINTEND(readability-identifier-naming)
