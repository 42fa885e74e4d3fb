// The messages of a session as plain values, and their bytes. The first byte of a message tells its kind: control
// messages are FlatBuffers (message.fbs), poses and keyframes are compact. Decoders accept any bytes and end in a valid
// value or an Error; every count is bounded before it is used. Pure functions; any thread; portable to WebAssembly.
//
// Compact messages arrive in order or not at all, so each is told by its difference from the last one of the same kind
// and connection; the first, and one that differs by too much, by itself. By itself (little-endian, varints as
// base/bytes.h has them):
//
//   byte 2   pose update   zigzag time (us); pose (wire_pose.h); varint received keyframe; zigzag received_at - time (us)
//   byte 3   keyframe      varint index, base; zigzag time (us); pose; varint width, height (pixels), double field of
//                          view; floats tau, ball, turn; uint32 fingerprint; delta
//
// After another, as bits (base/bits.h), of which the first three are 5 or 6; filled up to a byte with zeros:
//
//   5   pose update   the next pose and its time (wire_pose.h)
//                     2 bits: the received keyframe is 0 the same, 1 the next, 2 a later one
//                     if a later one: group of 1, how much later
//                     if not the same: group of 1 [8], (time - received_at) / 256 us, rounded down
//   6   keyframe      1 bit: is there anything unusual?  then 4 bits, of which each says whether something is told
//                     the next pose and its time
//                     bit 0: it is not the next keyframe, based on the last one: group of 2, index - last index, index - base
//                     bit 1: another lens: 16 bits of width, of height, 64 of the field of view, lower half first
//                     bit 2: another tau: its 32 bits
//                     bit 3: ball and turn are not both short floats: their 32 bits; without bit 3 a group of 2 [8], how much
//                            larger their upper 16 bits are than the last keyframe's
//                     8 bits of the fingerprint, from bit 8 (index mod 4) on
//                     to the next byte; delta
//
// A group of which there is at most one in a hundred messages (how much later, the order) has no width to remember: it
// begins with 0 each time.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/message/wire_pose.h"
#include "proto/refine/objects.h"
#include "proto/space/frame.h"
#include "proto/space/path.h"
#include "proto/space/pose.h"
#include "proto/space/view.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

inline constexpr uint32_t kProtocolVersion = 4;
inline constexpr size_t kMaxClientMessageBytes = 16u << 20;  // paths are the largest
inline constexpr size_t kMaxServerMessageBytes = 64u << 20;  // a first section is the largest
inline constexpr size_t kMaxGroundPoints = 65'536;

// P section 4; DESIGN section 4.
enum class Strategy : uint8_t { kDelay = 0, kCurrent = 1, kPredict = 2 };
enum class Predictor : uint8_t { kHold = 0, kConstantVelocity = 1, kConstantAcceleration = 2, kKnownPath = 3 };

// "delay", "current", "predict"; "hold", "velocity", "acceleration", "path". Nothing for other names.
const char* name(Strategy strategy);
const char* name(Predictor predictor);
std::optional<Strategy> strategyNamed(std::string_view name);
std::optional<Predictor> predictorNamed(std::string_view name);

struct ViewRequest {
  Lens lens;
  double tau_px = 0;  // 0: the server's own
  Strategy strategy = Strategy::kPredict;
  Predictor predictor = Predictor::kConstantVelocity;
  Duration keyframe_interval;         // 0: the server's own
  uint32_t max_triangles = 0;         // what the client can draw; 0: no limit
  uint32_t max_bytes_per_second = 0;  // and take; 0: no limit
};

struct TourRequest {
  uint32_t id = 0;
  std::string name;  // survey, canyon, spin, orbit
  double seconds = 60;
};

struct GroundRequest {
  uint32_t id = 0;
  std::vector<glm::dvec2> places;  // lattice positions
};

struct Welcome {
  uint64_t scene_id = 0;
  std::string title;
  std::string crs;
  Frame frame;
  GridShape shape;
  int32_t lowest = 0, highest = 0;      // heights over the data, steps
  std::vector<int32_t> corner_heights;  // (roots_x + 1) * (roots_y + 1), row by row from the south, steps
  std::vector<int32_t> centre_heights;  // roots_x * roots_y
  double tau_px = 1;                    // in force
  Duration keyframe_interval;           // in force
  std::vector<ObjectModel> models;
  std::vector<ObjectPlacement> objects;  // with models: what ObjectSet::create accepts
};

struct TourReply {
  uint32_t id = 0;
  Duration step;
  std::vector<Pose> poses;
};

struct GroundReply {
  uint32_t id = 0;
  std::vector<float> heights_m;  // NaN beyond the data
};

struct Refusal {
  std::string message;  // then the server closes
};

// Client to server, many a second: where the viewer is, and which keyframe it last received.
struct PoseUpdate {
  TimedPose pose;                  // the client's clock; eye to the millimetre, orientation to 1e-4 rad
  uint32_t received_keyframe = 0;  // 0: none yet
  Time received_at;                // the client's clock
};

// Client to server, after the welcome to a new connection and before any pose: the section that the client holds, of
// the scene that the welcome names. The next keyframe starts from it; if the server cannot take it, from nothing.
struct Resume {
  uint64_t scene_id = 0;
  uint32_t keyframe = 0;     // index of the keyframe whose section it is
  Time time;                 // and its time, the client's clock
  uint32_t fingerprint = 0;  // of the section
  Bytes section;             // encodeSections (section_codec.h)
};

// Server to client: a keyframe's header; the cut delta's bytes follow it in the message.
struct KeyframeHeader {
  uint32_t index = 0;                      // counts from 1
  uint32_t base_index = 0;                 // keyframe whose section the delta starts from; 0 is the empty section
  Time time;                               // t_i, the client's clock
  Pose pose;                               // computed for this pose
  Lens lens;                               // and this field of view
  float tau_px = 1;                        // tolerance in force
  float region_radius_m = 0;               // tau is kept for eyes this near to pose.eye,
  float region_angle_rad = 0;              // turned by no more than this
  uint32_t fingerprint = 0;                // of the section that results
  uint32_t fingerprint_mask = 0xffffffff;  // which of its bits are told
};

using ClientMessage = std::variant<ViewRequest, Path, TourRequest, GroundRequest, PoseUpdate, Resume>;

struct KeyframeMessage {
  KeyframeHeader header;
  ByteSpan delta;  // into the message's bytes
};
using ServerMessage = std::variant<Welcome, TourReply, GroundReply, Refusal, KeyframeMessage>;

// What the compact messages of one direction of a connection are told against: the last ones, as both ends have them.
// The sender has one, the receiver another; a new connection begins with new ones at both ends. One owner.
struct PoseMemory {
  WirePoses poses;
  GroupWidth age_width{8};
  uint32_t received_keyframe = 0;
  Time received_at;
};
struct KeyframeMemory {
  WirePoses poses;
  GroupWidth region_width{8};  // of ball and turn
  KeyframeHeader last;
};

Bytes encode(const ViewRequest& message);
Bytes encode(const Path& message);
Bytes encode(const TourRequest& message);
Bytes encode(const GroundRequest& message);
Bytes encode(const Resume& message);
Bytes encode(const Welcome& message);
Bytes encode(const TourReply& message);
Bytes encode(const GroundReply& message);
Bytes encode(const Refusal& message);
// At most 16 bytes after the first where a camera moves as vehicles and hands do; on tours at 20 a second 3 to 5 in the
// mean. `received_at` arrives up to 256 us later than it was, never earlier. The pose is usable.
Bytes encode(const PoseUpdate& message, PoseMemory& memory);
// Appends the header; the caller appends the delta. On tours at 5 keyframes a second 6 to 9 bytes in the mean after the
// first if ball and turn are short floats, some 6 more otherwise. The pose is usable.
void encodeHeader(const KeyframeHeader& header, KeyframeMemory& memory, Bytes& out);
// By themselves, as the first of a connection.
Bytes encode(const PoseUpdate& message);
void encodeHeader(const KeyframeHeader& header, Bytes& out);

// The pose that the other end decodes, of a pose update and of a keyframe's header; what is promised for a keyframe is
// promised for this one.
Pose asSent(const Pose& pose);
Pose asSentInHeader(const Pose& pose);

// What a keyframe's section was computed for.
inline View viewOf(const KeyframeHeader& h) {
  return {h.pose, h.lens, h.tau_px, h.region_radius_m, h.region_angle_rad};
}

// The smallest short float that is no smaller than `value`, 0 to 10^30: one of 8 significant bits, the lower 16 of its
// 32 zero. At most 0.8 % larger. What is promised for a keyframe's ball and turn costs less on the wire if it is short.
float shortAtLeast(double value);

// Values are checked for what their types promise: usable lenses and poses, valid frames, shapes and paths. After an
// Error the memory is of no use any more, nor is the connection.
Result<ClientMessage> decodeClientMessage(ByteSpan bytes, PoseMemory& memory);
Result<ServerMessage> decodeServerMessage(ByteSpan bytes, KeyframeMemory& memory);
// Of a connection on which no pose, or keyframe, came before.
Result<ClientMessage> decodeClientMessage(ByteSpan bytes);
Result<ServerMessage> decodeServerMessage(ByteSpan bytes);

}  // namespace foreland::proto
