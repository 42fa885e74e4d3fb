// Control messages: what a client asks for, and what the server answers, besides poses and keyframes (compact.h). Plain
// values, and their bytes: byte 1, then a FlatBuffer (message.fbs). Decoders accept any bytes and end in a value that
// keeps what its type says (usable lenses and poses, valid frames, shapes and paths) or in an Error; every count is
// bounded before it is used. Pure functions; any thread; portable to WebAssembly.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/imagery/tile.h"
#include "proto/imagery/tile_memory.h"
#include "proto/message/sight_message.h"
#include "proto/refine/surface/objects.h"
#include "proto/section/epochs.h"
#include "proto/space/frame.h"
#include "proto/space/path.h"
#include "proto/space/pose.h"
#include "proto/space/vertical.h"
#include "proto/topology/grid.h"

namespace foreland::proto {

inline constexpr uint32_t kProtocolVersion = 15;

// What a client spends, unless told otherwise, on terrain that it has been sent and does not need now.
inline constexpr uint32_t kDefaultMemoryBytes = 16u << 20;
inline constexpr uint32_t kMaxUndulationSide = 33;
inline constexpr size_t kMaxGroundPoints = 65'536;
inline constexpr uint32_t kMaxOrder = 3;
inline constexpr double kMaxEyeRadius_m = 100;

// P section 4; THEORY section 4.
enum class Strategy : uint8_t { kDelay = 0, kCurrent = 1, kPredict = 2 };
enum class Predictor : uint8_t {
  kHold = 0,
  kConstantVelocity = 1,
  kConstantAcceleration = 2,
  kKnownPath = 3,
  kDoubleExponential = 4,
  kKalman = 5
};
// Their names, separated by commas, for messages that ask for one of them.
std::string predictorNames();

// "delay", "current", "predict"; "hold", "velocity", "acceleration", "path". Empty for other names.
const char* name(Strategy strategy);
const char* name(Predictor predictor);
std::optional<Strategy> strategyNamed(std::string_view name);
std::optional<Predictor> predictorNamed(std::string_view name);

struct ViewRequest {
  Lens lens;          // a width or height of 0: nothing is shown for now, as in a window that is hidden
  double tau_px = 0;  // 0: the server's own
  Strategy strategy = Strategy::kPredict;
  Predictor predictor = Predictor::kConstantVelocity;
  Duration keyframe_interval;         // 0: the server's own
  Duration longest_interval{};        // above keyframe_interval: adaptive, between the two; 0: fixed
  uint32_t max_triangles = 0;         // that the client can draw; 0: no limit
  uint32_t max_bytes_per_second = 0;  // that the client can receive; 0: no limit
  // Whether what ridges hide may be left out. If the first request of a connection says no, later ones cannot say yes.
  bool occlusion = false;
  // How much the client remembers of nodes that it does not need now (refine/node_memory.h). Only the first request of
  // a connection counts.
  uint32_t memory_bytes = kDefaultMemoryBytes;
  // Which layers of tiles the client wants; and how much it holds of them (imagery/tile_memory.h), of which only the
  // first request of a connection counts.
  bool relief = false, imagery = false;
  uint32_t tile_bytes = kDefaultTileBytes;
  // A frame blends one keyframe more, so a keyframe is shown, in part, for order + 1 intervals around its time, and its
  // region holds for that. 1 to kMaxOrder; above 1 keyframes do not adapt.
  uint32_t order = 1;
  // A frame is seen by eyes that are this far from the pose's at most, as the two of a head: keyframes' regions are so
  // much wider. At most kMaxEyeRadius_m.
  double eye_radius_m = 0;

  bool wants(TileContent content) const { return content == TileContent::kRelief ? relief : imagery; }
  bool showsNothing() const { return lens.width_px == 0 || lens.height_px == 0; }
};

// The tiles that a client holds from an earlier connection, the oldest first. Follows the first request.
struct HeldTiles {
  std::vector<TileId> tiles;  // at most kMaxTilesHeld
};

struct TourRequest {
  uint32_t id = 0;
  std::string name;  // survey, canyon, spin, orbit
  double seconds = 60;
};

struct GroundRequest {
  uint32_t id = 0;
  std::vector<glm::dvec2> positions;  // on the lattice
};

struct Welcome {
  uint64_t scene_id = 0;
  std::string title;
  std::string crs;
  Frame frame;
  GridShape shape;
  int32_t lowest = 0, highest = 0;      // heights over the data, height quanta
  std::vector<int32_t> corner_heights;  // (roots_x + 1) * (roots_y + 1), row by row from the south, height quanta
  std::vector<int32_t> centre_heights;  // roots_x * roots_y
  double tau_px = 1;                    // in force
  Duration keyframe_interval;           // in force
  Duration longest_interval{};          // in force; 0: keyframe_interval is fixed
  std::vector<ObjectModel> models;
  std::vector<ObjectPlacement> objects;  // with models: what ObjectSet::create accepts
  bool occlusion = false;                // deltas on this connection carry hidden blocks (codec/block_coder.h)
  uint32_t memory_bytes = 0;             // that the client remembers, at most what it asked for
  std::vector<Epoch> epochs;             // what Epochs::create accepts; empty: the scene does not change in time
  EpochBlend epoch_blend = EpochBlend::kLinear;
  std::vector<BaseOffset> base_offsets;  // those that are not zero
  uint32_t max_offset = 0;               // the largest either way, of all vertices and epochs; at most kMaxOffset
  std::vector<TileLayer> tile_layers;    // at most one of each content
  uint32_t tile_bytes = 0;               // that the client holds, at most what it asked for
  VerticalDatum vertical{};              // undulations at most kMaxUndulationSide a side, as read-outs need them
};

struct TourReply {
  uint32_t id = 0;
  Duration step;
  std::vector<Pose> poses;
};

struct GroundReply {
  uint32_t id = 0;
  std::vector<float> heights_m;        // NaN beyond the data
  std::vector<float> undulations_m{};  // as many, or none where the scene knows no geoid
};

// The server closes the connection after it.
struct Refusal {
  std::string message;
};

using ClientControl = std::variant<ViewRequest, Path, TourRequest, GroundRequest, SceneClock, HeldTiles, SightRequest,
                                   ViewshedRequest, RequestCancel>;
using ServerControl = std::variant<Welcome, TourReply, GroundReply, Refusal, SightReply, ViewshedReply>;

Bytes encode(const ViewRequest& message);
Bytes encode(const Path& message);
Bytes encode(const TourRequest& message);
Bytes encode(const GroundRequest& message);
Bytes encode(const SceneClock& message);
Bytes encode(const HeldTiles& message);
Bytes encode(const Welcome& message);
Bytes encode(const TourReply& message);
Bytes encode(const GroundReply& message);
Bytes encode(const Refusal& message);

// The message is of kind kControl.
Result<ClientControl> decodeClientControl(ByteSpan bytes);
Result<ServerControl> decodeServerControl(ByteSpan bytes);

}  // namespace foreland::proto
