// Compact messages: pose updates, keyframe headers, and what a client resumes from. The first byte says which kind
// (kind.h). Decoders accept any bytes and end in a valid value or an Error. Pure functions; any thread; portable to
// WebAssembly.
//
// Messages of one kind and connection arrive in order or not at all, so each pose update and each keyframe header is
// coded as its difference from the one before; the first, and one that differs by too much, absolutely. Absolute ones
// are (little-endian, varints as base/bytes.h has them):
//
//   byte 2   pose update   zigzag time (us); pose (wire_pose.h), whose mark 1 says that the camera jumped; varint
//                          received keyframe; zigzag received_at - time (us)
//   byte 3   keyframe      varint index, base; zigzag time (us); pose; varint width, height (pixels), double field of
//                          view; floats tau, region radius, region angle; uint32 fingerprint; delta
//   byte 4   resume        uint64 scene; varint keyframe; zigzag time (us); uint32 fingerprint; section
//
// Delta-coded ones are bits (base/bits.h), of which the first three are 5 or 6; filled up to a byte with zeros:
//
//   5   pose update   the next pose and its time (wire_pose.h)
//                     2 bits: the received keyframe is 0 the same, 1 the next, 2 a later one
//                     if a later one: group of 1, how much later
//                     if not the same: group of 1 [8], (time - received_at) / 256 us, rounded down
//   6   keyframe      1 bit: is there anything unusual?  then 4 bits, each of which says whether a field follows
//                     the next pose and its time
//                     bit 0: it is not the next keyframe, based on the last one: group of 2, index - last index, index - base
//                     bit 1: another lens: 16 bits of width, of height, 64 of the field of view, lower half first
//                     bit 2: another tau: its 32 bits
//                     bit 3: region radius and angle are not both short floats: their 32 bits; without bit 3 a group of 2
//                            [8], how much larger their upper 16 bits are than the last keyframe's
//                     8 bits of the fingerprint, from bit 8 (index mod 4) on
//                     to the next byte; delta
//
// A group that occurs at most once in a hundred messages (how much later, the order) has no width to remember: it
// begins with 0 each time.
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "proto/message/wire_pose.h"
#include "proto/space/view.h"

namespace foreland::proto {

// Client to server, many times a second: where the viewer is, and which keyframe it last received.
struct PoseUpdate {
  TimedPose pose;                  // the client's clock; eye to the millimetre, orientation to 1e-4 rad
  uint32_t received_keyframe = 0;  // 0: none yet
  Time received_at;                // the client's clock
  // The camera has not moved here from the last pose, but jumped. Such a pose is sent absolutely.
  bool has_jumped = false;
};

// Client to server, after the welcome to a new connection and before any pose: the section that the client holds, of
// the scene that the welcome names. The next keyframe starts from it, or from nothing if the server cannot take it.
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
  Pose pose;                               // that it was computed for
  Lens lens;                               // and the field of view
  float tau_px = 1;                        // tolerance in force
  float region_radius_m = 0;               // tau is kept for eyes this near to pose.eye,
  float region_angle_rad = 0;              // turned by no more than this
  uint32_t fingerprint = 0;                // of the section that results
  uint32_t fingerprint_mask = 0xffffffff;  // which of its bits the message carried
  Time scene_time{};                       // whose ground it shows, in scenes with epochs; it is in the delta
  // The same where the blend of epochs is not linear: frames since the keyframe before show the ground at the scene
  // time between, not a mix of the ground at two times; and what the motion takes of the tolerance of frames.
  bool is_scene_step = false;
  float motion_px = 0;

  // That frames keep which show its section.
  float frameTolerance() const { return tau_px + motion_px; }
};

struct KeyframeMessage {
  KeyframeHeader header;
  ByteSpan delta;  // into the message's bytes
};

// What delta-coded messages of one direction of a connection refer to: the last ones, as both ends have them. The
// sender has one, the receiver another; a new connection begins with new ones at both ends. One owner.
struct PoseMemory {
  WirePoses poses;
  GroupWidth age_width{8};
  uint32_t received_keyframe = 0;
  Time received_at;
};
struct KeyframeMemory {
  WirePoses poses;
  GroupWidth region_width{8};  // of the region's radius and angle
  KeyframeHeader last;
};

Bytes encode(const Resume& message);
// At most 16 bytes after the first where a camera moves as vehicles and hands do; on tours at 20 a second 3 to 5 in the
// mean. `received_at` arrives up to 256 us later than it was, never earlier. The pose is usable.
Bytes encode(const PoseUpdate& message, PoseMemory& memory);
// Appends the header; the caller appends the delta. On tours at 5 keyframes a second 6 to 9 bytes in the mean after the
// first if the region's numbers are short floats, some 6 more otherwise. The pose is usable.
void encodeHeader(const KeyframeHeader& header, KeyframeMemory& memory, Bytes& out);
// Absolute, as the first of a connection.
Bytes encode(const PoseUpdate& message);
void encodeHeader(const KeyframeHeader& header, Bytes& out);

// The pose that the other end decodes, of a pose update and of a keyframe's header. A keyframe's error guarantee is for
// this one.
Pose asSent(const Pose& pose);
Pose asSentInHeader(const Pose& pose);

// The view for which a keyframe's section was computed.
inline View viewOf(const KeyframeHeader& h) {
  return {h.pose, h.lens, h.tau_px, h.region_radius_m, h.region_angle_rad};
}

// The smallest short float that is at least `value`, 0 to 10^30: one of 8 significant bits, the lower 16 of its 32
// zero. At most 0.8 % larger. A keyframe's region costs fewer bytes if its numbers are short.
float shortAtLeast(double value);

// The message is of one of the kinds of its type. After an Error the memory is of no use any more, nor is the
// connection.
Result<PoseUpdate> decodePose(ByteSpan bytes, PoseMemory& memory);
Result<Resume> decodeResume(ByteSpan bytes);
Result<KeyframeMessage> decodeKeyframe(ByteSpan bytes, KeyframeMemory& memory);

}  // namespace foreland::proto
