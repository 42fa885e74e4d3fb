#include "client/ground_supply.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "base/check.h"
#include "base/sort.h"
#include "proto/imagery/relief_codec.h"

namespace foreland::client {

namespace {

constexpr double kExactReach = 16;    // samples; faster cameras do with what there is
constexpr uint32_t kExactMargin = 8;  // asked for beyond the reach
constexpr uint32_t kMaxExactSide = 2 * (static_cast<uint32_t>(kExactReach) + kExactMargin) + 2;

// Both ends are instances of the same module, so values travel as they are.
template <class T>
void putSome(ByteWriter& out, const std::vector<T>& values) {
  out.put(static_cast<uint32_t>(values.size()));
  out.putBytes({reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(T)});
}
template <class T>
std::vector<T> takeSome(ByteReader& in) {
  const auto count = in.get<uint32_t>();
  CHECK_LE(count, in.remaining() / sizeof(T));
  std::vector<T> values(count);
  for (T& value : values) value = in.get<T>();
  return values;
}

void putPatch(ByteWriter& out, const GroundPatch& patch) {
  out.put(patch.low), out.put(patch.spacing), out.put(patch.columns);
  putSome(out, patch.heights_m);
}
GroundPatch takePatch(ByteReader& in) {
  GroundPatch patch{
      .low = in.get<glm::dvec2>(), .spacing = in.get<double>(), .columns = in.get<uint32_t>(), .heights_m = {}};
  patch.heights_m = takeSome<float>(in);
  return patch;
}

// Where samples are that lie beside an eye's: all of them; of a globe those of its face, for beyond a face's sides the
// lattice has other ground.
proto::LatticeBox samplesAbout(const proto::GridShape& shape, const proto::LatticePosition& eye) {
  if (!shape.is_cube) return {{0, 0}, {shape.samples_x - 1.0, shape.samples_y - 1.0}};
  const double side = shape.samples_y - 1.0, face = std::clamp(std::floor(eye.x / side), 0.0, 5.0);
  return {{face * side, 0}, {(face + 1) * side, side}};
}
// As it is asked for: of a face's east side, which positions name as another face's, what lies just inside.
glm::dvec2 askedFor(const proto::GridShape& shape, glm::dvec2 sample, const proto::LatticeBox& of) {
  constexpr double kInside = 1 - 0x1p-52;
  return shape.is_cube && sample.x == of.high.x ? glm::dvec2(sample.x * kInside, sample.y) : sample;
}

}  // namespace

std::vector<proto::TileId> reliefAbout(const TileStore& tiles, glm::dvec2 at, double reach) {
  const auto index = tiles.layerOf(proto::TileContent::kRelief);
  if (!index) return {};
  const proto::TileLayer& layer = tiles.layers()[*index];
  if (layer.isGlobe()) return {};  // its texels are no samples, and so bound no ground
  uint32_t level = 0;
  while (level + 1 < layer.levels() && 2 * reach > proto::kTilePayload * layer.texelAt(level)) ++level;
  const double side = proto::kTilePayload * layer.texelAt(level);
  const auto tileAt = [&](double x, double origin, uint32_t count) {
    return static_cast<uint32_t>(std::clamp(std::floor((x - origin) / side), 0.0, count - 1.0));
  };
  const auto columns = [&](double x) { return tileAt(x, layer.origin.x, layer.tilesX(level)); };
  const auto rows = [&](double y) { return tileAt(y, layer.origin.y, layer.tilesY(level)); };
  std::vector<proto::TileId> out;
  for (uint32_t y = rows(at.y - reach); y <= rows(at.y + reach); ++y)
    for (uint32_t x = columns(at.x - reach); x <= columns(at.x + reach); ++x) {
      proto::TileId tile{*index, static_cast<uint8_t>(level), x, y};
      while (tiles.find(tile) == nullptr && !layer.isCoarsest(tile)) tile = tile.parent();
      if (tiles.find(tile) != nullptr && std::find(out.begin(), out.end(), tile) == out.end()) out.push_back(tile);
    }
  const auto distance = [&](const proto::TileId& tile) {
    const proto::LatticeBox box = layer.boxOf(tile);
    return glm::distance(at, glm::clamp(at, box.low, glm::max(box.low, box.high)));
  };
  foreland::sort(out.begin(), out.end(), [&](const proto::TileId& a, const proto::TileId& b) {
    const double da = distance(a), db = distance(b);
    return da != db ? da < db : a.key() < b.key();
  });
  return out;
}

const Bytes& GroundSupply::update(Viewer& viewer, const glm::dvec3& eye, double reach) {
  if (scene_ != viewer.tiles().scene()) *this = GroundSupply(), scene_ = viewer.tiles().scene();
  const proto::LatticePosition at = viewer.frameGrid().transform().toLattice(eye);
  out_.clear();
  ByteWriter(out_).put(scene_);
  putMesh(viewer, at, reach);
  putTiles(viewer.tiles(), reliefAbout(viewer.tiles(), {at.x, at.y}, reach));
  putExact(viewer, at, reach);
  return out_;
}

void GroundSupply::putMesh(const Viewer& viewer, const proto::LatticePosition& eye, double reach) {
  GroundPatch mesh{.low = {eye.x - reach, eye.y - reach}, .spacing = reach, .columns = 3, .heights_m = {}};
  const proto::GridShape& shape = viewer.welcome()->shape;
  const proto::LatticeBox face = samplesAbout(shape, eye);
  for (const double y : {eye.y - reach, eye.y, eye.y + reach})
    for (const double x : {eye.x - reach, eye.x, eye.x + reach}) {
      // Beyond a face's side as high as at it.
      const glm::dvec2 at =
          shape.is_cube ? askedFor(shape, glm::clamp(glm::dvec2(x, y), face.low, face.high), face) : glm::dvec2(x, y);
      mesh.heights_m.push_back(
          static_cast<float>(viewer.groundHeight(at.x, at.y).value_or(std::numeric_limits<double>::quiet_NaN())));
    }
  ByteWriter out(out_);
  putPatch(out, mesh);
}

// All that are wanted and known at the other end are kept; of the others one is sent.
void GroundSupply::putTiles(const TileStore& tiles, const std::vector<proto::TileId>& wanted) {
  std::vector<uint64_t> keys;
  for (const proto::TileId& tile : wanted) keys.push_back(tile.key());
  const auto isNew = [&](const proto::TileId& tile) { return !sent_.contains(tile.key()); };
  const auto news = std::find_if(wanted.begin(), wanted.end(), isNew);
  // What is wanted only in part stays whole: coarser tiles, until the finer ones have come.
  is_fine_ = !wanted.empty() && news == wanted.end() &&
             std::all_of(wanted.begin(), wanted.end(), [](const proto::TileId& tile) { return tile.level == 0; });
  std::vector<uint64_t> kept = keys;
  if (news != wanted.end()) kept.insert(kept.end(), sent_.begin(), sent_.end());
  ByteWriter out(out_);
  putSome(out, kept);
  std::erase_if(sent_, [&](uint64_t key) { return std::find(kept.begin(), kept.end(), key) == kept.end(); });
  out.put(static_cast<uint32_t>(news == wanted.end() ? 0 : 1));
  if (news == wanted.end()) return;
  sent_.insert(news->key());
  steps_.resize(proto::kTileTexels);
  // A tile that is damaged tells nothing: all of its heights are far below.
  if (!proto::decodeRelief(tiles.find(*news)->coded, steps_).ok())
    std::fill(steps_.begin(), steps_.end(), -proto::kMaxReliefSteps);
  out.put(news->key());
  putSome(out, steps_);
}

// Near the ground, and where neither relief nor earlier replies tell all.
bool GroundSupply::mayNeedExact(const Viewer& viewer, const proto::LatticePosition& eye, double reach) const {
  const proto::Welcome& welcome = *viewer.welcome();
  if (is_fine_ || asked_ || reach > kExactReach || !welcome.epochs.empty()) return false;
  const auto [low, end] = samplesAbout(welcome.shape, eye);
  if (eye.x < low.x || eye.y < low.y || eye.x > end.x || eye.y > end.y) return false;
  const proto::FrameTransform& frame = viewer.frameGrid().transform();
  const double spacing_m =
      glm::distance(frame.toScene(eye), frame.toScene(proto::LatticePosition{eye.x + 1, eye.y, eye.height_m}));
  double highest_m = welcome.highest * welcome.frame.height_quantum_m;
  for (const proto::TileId& tile : reliefAbout(viewer.tiles(), {eye.x, eye.y}, reach))
    highest_m = std::min(highest_m, double{viewer.tiles().find(tile)->bounds.highest_m});
  if (eye.height_m > highest_m + 2 * reach * spacing_m) return false;
  const glm::dvec2 high = exact_.low + glm::dvec2(exact_.columns, exact_rows_) - 1.0;
  return exact_.columns == 0 || exact_.low.x > std::max(low.x, eye.x - reach) ||
         exact_.low.y > std::max(low.y, eye.y - reach) || high.x < std::min(end.x, eye.x + reach) ||
         high.y < std::min(end.y, eye.y + reach);
}

void GroundSupply::putExact(Viewer& viewer, const proto::LatticePosition& eye, double reach) {
  if (mayNeedExact(viewer, eye, reach)) ask(viewer, eye, reach);
  auto reply = asked_ ? viewer.takeGround(asked_->id) : std::nullopt;
  const bool is_ours = reply && reply->heights_m.size() % asked_->patch.columns == 0;
  ByteWriter out(out_);
  out.put(static_cast<uint32_t>(is_ours ? 1 : 0));
  if (!is_ours) return;
  exact_ = asked_->patch;
  exact_rows_ = static_cast<uint32_t>(reply->heights_m.size() / exact_.columns);
  asked_.reset();
  GroundPatch patch = exact_;
  patch.heights_m = std::move(reply->heights_m);
  putPatch(out, patch);
}

void GroundSupply::ask(Viewer& viewer, const proto::LatticePosition& eye, double reach) {
  const proto::GridShape& shape = viewer.welcome()->shape;
  const proto::LatticeBox of = samplesAbout(shape, eye);
  const auto range = [&](double at, double first, double last) {
    const double low = std::clamp(std::floor(at - reach - kExactMargin), first, last);
    return glm::dvec2(low, std::clamp(std::ceil(at + reach + kExactMargin), low, last));
  };
  const glm::dvec2 x = range(eye.x, of.low.x, of.high.x), y = range(eye.y, of.low.y, of.high.y);
  GroundPatch patch{.low = {x.x, y.x}, .columns = static_cast<uint32_t>(x.y - x.x) + 1, .heights_m = {}};
  CHECK_LE(patch.columns, kMaxExactSide);
  std::vector<glm::dvec2> samples;
  for (double row = y.x; row <= y.y; ++row)
    for (double column = x.x; column <= x.y; ++column) samples.push_back(askedFor(shape, {column, row}, of));
  asked_ = Asked{viewer.requestGround(std::move(samples)), std::move(patch)};
}

void GroundFeed::take(ByteSpan update, const std::optional<proto::TileLayer>& relief) {
  ByteReader in(update);
  if (const auto scene = in.get<uint32_t>(); scene != scene_) heights_.enter(relief), scene_ = scene;
  heights_.setMesh(takePatch(in));
  heights_.keep(takeSome<uint64_t>(in));
  if (in.get<uint32_t>() == 1) {
    const auto tile = proto::TileId::of(in.get<uint64_t>());
    heights_.add(tile, takeSome<int32_t>(in));
  }
  if (in.get<uint32_t>() == 1) heights_.setExact(takePatch(in));
}

}  // namespace foreland::client
