// The welcome as bytes: all that a client is told of a scene before any node.
#include <algorithm>
#include <cmath>

#include "proto/message/control_buffer.h"
#include "proto/section/bounds.h"

namespace foreland::proto {

namespace {

Result<TileLayer> layerOf(const fb::TileLayer& m, const GridShape& shape) {
  TileLayer layer;
  if (shape.is_cube) layer.face_steps = 1u << shape.root_log2;
  layer.content = static_cast<TileContent>(m.content());
  layer.coding = static_cast<TileCoding>(m.coding());
  layer.width = m.width();
  layer.height = m.height();
  if (m.origin()) layer.origin = vectorOf(*m.origin());
  layer.texel = m.texel();
  layer.step_m = m.step_m();
  layer.attribution = text(m.attribution(), kMaxTextBytes);
  if (Status s = layer.validate(); !s.ok()) return malformed(s.error().message);
  return layer;
}

Status readTiles(const fb::Welcome& m, Welcome& out) {
  out.tile_bytes = m.tile_bytes();
  if (!m.tile_layers()) return {};
  if (m.tile_layers()->size() > kMaxTileLayers) return malformed("too many layers of tiles");
  for (const fb::TileLayer* each : *m.tile_layers()) {
    auto layer = layerOf(*each, out.shape);
    if (!layer) return layer.error();
    if (!out.tile_layers.empty() && out.tile_layers.front().content == layer->content)
      return malformed("two layers of tiles have the same content");
    out.tile_layers.push_back(std::move(*layer));
  }
  return {};
}

Result<Frame> frameOf(const fb::Frame* m, const GridShape& shape) {
  if (!m || !m->anchor() || !m->axis_x_m() || !m->axis_y_m() || !m->map_origin_m() || !m->origin())
    return malformed("the welcome lacks its frame");
  Frame f;
  f.kind = static_cast<FrameKind>(m->kind());
  f.height_quantum_m = m->height_quantum_m();
  f.anchor = vectorOf(*m->anchor());
  f.axis_x_m = vectorOf(*m->axis_x_m());
  f.axis_y_m = vectorOf(*m->axis_y_m());
  f.map_origin_m = vectorOf(*m->map_origin_m());
  f.latitude0_rad = m->latitude0_rad();
  f.longitude0_rad = m->longitude0_rad();
  f.latitude_step_rad = m->latitude_step_rad();
  f.longitude_step_rad = m->longitude_step_rad();
  f.semi_major_m = m->semi_major_m();
  f.flattening = m->flattening();
  if (shape.is_cube) f.face_steps = 1u << shape.root_log2;
  f.origin = {m->origin()->latitude_rad(), m->origin()->longitude_rad(), m->origin()->height_m()};
  const double max_x = std::ldexp(shape.roots_x, static_cast<int>(shape.root_log2));
  const double max_y = std::ldexp(shape.roots_y, static_cast<int>(shape.root_log2));
  if (Status s = f.validate(max_x, max_y); !s.ok()) return s.error();
  return f;
}

bool readHeights(const flatbuffers::Vector<int32_t>* in, uint64_t expected, std::vector<int32_t>& out) {
  if (!in || in->size() != expected) return false;
  out.assign(in->begin(), in->end());
  return std::all_of(out.begin(), out.end(), [](int32_t h) { return h >= -kMaxHeight && h <= kMaxHeight; });
}

Result<ObjectModel> modelOf(const fb::Model& m) {
  ObjectModel model;
  if (!m.faces() || m.faces()->size() % 3 != 0 || m.faces()->size() / 3 > BaseMesh::kMaxFaces || !m.base() ||
      m.base()->size() % 3 != 0)
    return malformed("a model's faces or vertices are not in threes, or too many");
  model.shape.rule = static_cast<MeshRule>(m.rule());
  model.shape.halvings = m.halvings();
  model.shape.vertex_count = m.vertices();
  for (uint32_t i = 0; i < m.faces()->size(); i += 3)
    model.shape.faces.push_back({m.faces()->Get(i), m.faces()->Get(i + 1), m.faces()->Get(i + 2)});
  for (uint32_t i = 0; i < m.base()->size(); i += 3)
    model.base.emplace_back(m.base()->Get(i), m.base()->Get(i + 1), m.base()->Get(i + 2));
  model.quantum_m = m.quantum_m();
  model.atlas_side = m.atlas_side();
  if (m.pose_epochs()) {
    if (m.pose_epochs()->size() > kMaxPoses) return malformed("a model has too many poses");
    model.pose_epochs.assign(m.pose_epochs()->begin(), m.pose_epochs()->end());
  }
  if (m.base_moves()) {
    if (m.base_moves()->size() % 3 != 0 || m.base_moves()->size() > kMaxPoses * m.base()->size())
      return malformed("the moves of a model's base vertices are not in threes, or too many");
    for (uint32_t i = 0; i < m.base_moves()->size(); i += 3)
      model.base_moves.emplace_back(m.base_moves()->Get(i), m.base_moves()->Get(i + 1), m.base_moves()->Get(i + 2));
  }
  return model;
}

// After epochs.
Status readObjects(const fb::Welcome& m, Welcome& out) {
  if (m.models()) {
    if (m.models()->size() > ObjectSet::kMaxModels) return malformed("too many models");
    for (uint32_t i = 0; i < m.models()->size(); ++i) {
      auto model = modelOf(*m.models()->Get(i));
      if (!model) return model.error();
      out.models.push_back(std::move(*model));
    }
  }
  if (m.objects()) {
    if (m.objects()->size() > ObjectSet::kMaxObjects) return malformed("too many objects");
    for (size_t i = 0; i < m.objects()->size(); ++i) {
      const fb::Placement p = structAt(*m.objects(), i);
      const auto& q = p.orientation();
      out.objects.push_back({p.model(),
                             {p.position().x(), p.position().y(), p.position().z()},
                             glm::dquat(q.w(), q.x(), q.y(), q.z()),
                             p.scale(),
                             {}});
    }
  }
  const Epochs epochs = Epochs::create(out.shape, out.epochs, out.epoch_blend).value();
  if (auto set = ObjectSet::create(out.models, out.objects, epochs); !set) return set.error();
  return {};
}

Status readEpochs(const fb::Welcome& m, Welcome& out) {
  if (m.epochs()) {
    if (m.epochs()->size() > Epochs::kMax) return malformed("too many epochs");
    for (size_t i = 0; i < m.epochs()->size(); ++i) {
      const fb::Epoch e = structAt(*m.epochs(), i);
      out.epochs.push_back({Time{e.time_us()}, {e.x(), e.y(), e.width(), e.height()}});
    }
  }
  const auto blend = epochBlendOf(m.epoch_blend());
  if (!blend) return malformed("its epochs are blended in an unknown way; reload or update");
  out.epoch_blend = *blend;
  if (auto epochs = Epochs::create(out.shape, out.epochs, *blend); !epochs) return epochs.error();
  out.max_offset = m.max_offset();
  if (out.max_offset > uint32_t{kMaxOffset}) return malformed("the largest offset is absurd");
  if (!m.base_offsets()) return {};
  const size_t vertices = out.corner_heights.size() + out.centre_heights.size();
  if (m.base_offsets()->size() > vertices * out.epochs.size()) return malformed("too many offsets of base vertices");
  for (size_t i = 0; i < m.base_offsets()->size(); ++i) {
    const fb::BaseOffset o = structAt(*m.base_offsets(), i);
    if (o.epoch() >= out.epochs.size() || o.vertex() >= vertices || std::abs(int64_t{o.quanta()}) > kMaxOffset)
      return malformed("an offset of a base vertex is of no epoch or no vertex, or absurd");
    out.base_offsets.push_back({o.epoch(), o.vertex(), o.quanta()});
  }
  return {};
}

// After objects and epochs.
Status readRises(const fb::Welcome& m, Welcome& out) {
  if (!m.object_rises()) return {};
  if (m.object_rises()->size() > out.objects.size() * out.epochs.size()) return malformed("too many rises of objects");
  std::vector<std::vector<int32_t>> quanta(out.objects.size());
  for (size_t i = 0; i < m.object_rises()->size(); ++i) {
    const fb::ObjectRise r = structAt(*m.object_rises(), i);
    if (r.epoch() >= out.epochs.size() || r.object() >= out.objects.size() ||
        std::abs(int64_t{r.quanta()}) > kMaxOffset)
      return malformed("a rise is of no epoch or no object, or absurd");
    quanta[r.object()].resize(out.epochs.size());
    quanta[r.object()][r.epoch()] = r.quanta();
  }
  const Epochs epochs = Epochs::create(out.shape, out.epochs, out.epoch_blend).value();
  for (size_t i = 0; i < quanta.size(); ++i)
    if (!quanta[i].empty())
      out.objects[i].rise = GroundRise(std::move(quanta[i]), epochs, out.frame, out.objects[i].position);
  return {};
}

Status readVertical(const fb::VerticalDatum* m, VerticalDatum& out) {
  if (!m) return {};
  out.zero_surface = static_cast<ZeroSurface>(m->zero_surface());
  out.name = text(m->name(), kMaxTextBytes);
  out.geoid = text(m->geoid(), kMaxTextBytes);
  UndulationGrid& grid = out.undulations;
  grid.columns = m->columns();
  grid.rows = m->rows();
  if (grid.columns > kMaxUndulationSide || grid.rows > kMaxUndulationSide)
    return malformed("the welcome has more undulations than read-outs need");
  if (m->first()) grid.first = vectorOf(*m->first());
  if (m->step()) grid.step = vectorOf(*m->step());
  grid.max_error_m = m->max_error_m();
  if (m->undulations_m()) grid.metres.assign(m->undulations_m()->begin(), m->undulations_m()->end());
  if (Status s = out.validate(); !s.ok()) return malformed(s.error().message);
  return {};
}

}  // namespace

Result<Welcome> readWelcome(const fb::Welcome& m) {
  if (m.protocol() != kProtocolVersion)
    return malformed("the server speaks another protocol version; reload or update");
  if (!m.shape()) return malformed("the welcome lacks its shape");
  Welcome out;
  out.scene_id = m.scene_id();
  out.title = text(m.title(), kMaxTextBytes);
  out.crs = text(m.crs(), kMaxTextBytes);
  const fb::Shape& s = *m.shape();
  out.shape = {s.roots_x(),
               s.roots_y(),
               s.root_log2(),
               s.samples_x(),
               s.samples_y(),
               s.sparse_levels(),
               m.frame() && m.frame()->kind() == static_cast<uint8_t>(FrameKind::kGlobe)};
  if (auto grid = GridTopology::create(out.shape); !grid) return grid.error();
  auto frame = frameOf(m.frame(), out.shape);
  if (!frame) return frame.error();
  out.frame = *frame;
  const uint64_t rx = out.shape.roots_x, ry = out.shape.roots_y;
  if (!readHeights(m.corner_heights(), (rx + 1) * (ry + 1), out.corner_heights) ||
      !readHeights(m.centre_heights(), rx * ry, out.centre_heights))
    return malformed("the base heights do not fit the shape");
  out.lowest = m.lowest();
  out.highest = m.highest();
  out.tau_px = m.tau_px();
  out.keyframe_interval = {m.keyframe_interval_us()};
  out.longest_interval = {m.longest_interval_us()};
  out.occlusion = m.occlusion();
  out.memory_bytes = m.memory_bytes();
  if (!(out.tau_px > 0) || out.keyframe_interval.us <= 0)
    return malformed("the welcome's tolerance or interval is not positive");
  if (Status epochs = readEpochs(m, out); !epochs.ok()) return epochs.error();
  if (Status objects = readObjects(m, out); !objects.ok()) return objects.error();
  if (Status rises = readRises(m, out); !rises.ok()) return rises.error();
  if (Status tiles = readTiles(m, out); !tiles.ok()) return tiles.error();
  if (Status vertical = readVertical(m.vertical(), out.vertical); !vertical.ok()) return vertical.error();
  return out;
}

namespace {

fb::Geodetic toFb(const Geodetic& g) { return {g.latitude_rad, g.longitude_rad, g.height_m}; }

flatbuffers::Offset<fb::Frame> putFrame(Builder& b, const Frame& f) {
  const fb::Vec2 anchor = bufferOf(f.anchor), axis_x = bufferOf(f.axis_x_m), axis_y = bufferOf(f.axis_y_m),
                 map = bufferOf(f.map_origin_m);
  const fb::Geodetic origin = toFb(f.origin);
  return fb::CreateFrame(b, static_cast<uint8_t>(f.kind), f.height_quantum_m, &anchor, &axis_x, &axis_y, &map,
                         f.latitude0_rad, f.longitude0_rad, f.latitude_step_rad, f.longitude_step_rad, f.semi_major_m,
                         f.flattening, &origin);
}

flatbuffers::Offset<flatbuffers::Vector<flatbuffers::Offset<fb::TileLayer>>> putLayers(
    Builder& b, const std::vector<TileLayer>& layers) {
  if (layers.empty()) return {};
  std::vector<flatbuffers::Offset<fb::TileLayer>> each;
  for (const TileLayer& m : layers) {
    const auto attribution = b.CreateString(m.attribution);
    const fb::Vec2 origin = bufferOf(m.origin);
    each.push_back(fb::CreateTileLayer(b, static_cast<uint8_t>(m.content), static_cast<uint8_t>(m.coding), m.width,
                                       m.height, &origin, m.texel, m.step_m, attribution));
  }
  return b.CreateVector(each);
}

flatbuffers::Offset<fb::Model> putModel(Builder& b, const ObjectModel& m) {
  std::vector<uint32_t> faces;
  std::vector<int32_t> base;
  for (const BaseFace& f : m.shape.faces) faces.insert(faces.end(), f.begin(), f.end());
  for (const glm::ivec3& p : m.base) base.insert(base.end(), {p.x, p.y, p.z});
  const auto faces_at = b.CreateVector(faces);
  const auto base_at = b.CreateVector(base);
  flatbuffers::Offset<flatbuffers::Vector<uint32_t>> epochs_at;
  flatbuffers::Offset<flatbuffers::Vector<int32_t>> moves_at;
  if (!m.pose_epochs.empty()) {
    std::vector<int32_t> moves;
    for (const glm::ivec3& move : m.base_moves) moves.insert(moves.end(), {move.x, move.y, move.z});
    epochs_at = b.CreateVector(m.pose_epochs);
    moves_at = b.CreateVector(moves);
  }
  return fb::CreateModel(b, static_cast<uint8_t>(m.shape.rule), m.shape.halvings, m.shape.vertex_count, faces_at,
                         base_at, m.quantum_m, m.atlas_side, epochs_at, moves_at);
}

flatbuffers::Offset<fb::VerticalDatum> putVertical(Builder& b, const VerticalDatum& m) {
  if (m.zero_surface == ZeroSurface::kUnstated) return {};
  const UndulationGrid& grid = m.undulations;
  const auto name = b.CreateString(m.name), geoid = b.CreateString(m.geoid);
  flatbuffers::Offset<flatbuffers::Vector<float>> undulations;
  if (!grid.isEmpty()) undulations = b.CreateVector(grid.metres);
  const fb::Vec2 first = bufferOf(grid.first), step = bufferOf(grid.step);
  return fb::CreateVerticalDatum(b, static_cast<uint8_t>(m.zero_surface), name, geoid, &first, &step, grid.columns,
                                 grid.rows, undulations, grid.max_error_m);
}

fb::Placement toFb(const ObjectPlacement& p) {
  const glm::dquat& q = p.orientation;
  return {fb::Vec3(p.position.x, p.position.y, p.position.z), fb::Quat(q.w, q.x, q.y, q.z), p.scale, p.model};
}

}  // namespace

Bytes encode(const Welcome& m) {
  Builder b;
  flatbuffers::Offset<flatbuffers::Vector<flatbuffers::Offset<fb::Model>>> models;
  flatbuffers::Offset<flatbuffers::Vector<const fb::Placement*>> objects;
  if (!m.objects.empty()) {
    std::vector<flatbuffers::Offset<fb::Model>> each;
    for (const ObjectModel& model : m.models) each.push_back(putModel(b, model));
    models = b.CreateVector(each);
    objects = b.CreateVectorOfStructs<fb::Placement>(m.objects.size(),
                                                     [&](size_t i, fb::Placement* out) { *out = toFb(m.objects[i]); });
  }
  flatbuffers::Offset<flatbuffers::Vector<const fb::Epoch*>> epochs;
  flatbuffers::Offset<flatbuffers::Vector<const fb::BaseOffset*>> base_offsets;
  if (!m.epochs.empty()) {
    epochs = b.CreateVectorOfStructs<fb::Epoch>(m.epochs.size(), [&](size_t i, fb::Epoch* out) {
      const LatticeWindow& w = m.epochs[i].moved;
      *out = {m.epochs[i].time.us, w.x, w.y, w.width, w.height};
    });
    base_offsets = b.CreateVectorOfStructs<fb::BaseOffset>(m.base_offsets.size(), [&](size_t i, fb::BaseOffset* out) {
      *out = {m.base_offsets[i].epoch, m.base_offsets[i].vertex, m.base_offsets[i].quanta};
    });
  }
  std::vector<fb::ObjectRise> rises;
  for (uint32_t i = 0; i < m.objects.size(); ++i)
    for (uint32_t epoch = 0; epoch < m.objects[i].rise.quanta.size(); ++epoch)
      if (const int32_t quanta = m.objects[i].rise.quanta[epoch]; quanta != 0) rises.push_back({epoch, i, quanta});
  flatbuffers::Offset<flatbuffers::Vector<const fb::ObjectRise*>> object_rises;
  if (!rises.empty()) object_rises = b.CreateVectorOfStructs(rises);
  const auto layers = putLayers(b, m.tile_layers);
  const auto vertical = putVertical(b, m.vertical);
  const auto title = b.CreateString(m.title), crs = b.CreateString(m.crs);
  const auto frame = putFrame(b, m.frame);
  const auto shape = fb::CreateShape(b, m.shape.roots_x, m.shape.roots_y, m.shape.root_log2, m.shape.samples_x,
                                     m.shape.samples_y, m.shape.sparse_levels);
  const auto corners = b.CreateVector(m.corner_heights), centres = b.CreateVector(m.centre_heights);
  const auto body = fb::CreateWelcome(b, kProtocolVersion, m.scene_id, title, crs, frame, shape, m.lowest, m.highest,
                                      corners, centres, m.tau_px, static_cast<uint32_t>(m.keyframe_interval.us), models,
                                      objects, m.occlusion, m.memory_bytes, epochs, base_offsets, layers, m.tile_bytes,
                                      static_cast<uint32_t>(m.longest_interval.us), m.max_offset, object_rises,
                                      static_cast<uint32_t>(m.epoch_blend), vertical);
  return finish(b, fb::Body_Welcome, body.Union());
}

}  // namespace foreland::proto
