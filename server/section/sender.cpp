#include "server/section/sender.h"

#include <algorithm>

namespace foreland::server {

namespace {

// Whether the section of `b` is at most about twice that of `a`: its region is hardly larger and near, and tolerance
// and direction differ little.
bool isSimilar(const proto::View& a, const proto::View& b) {
  constexpr double kLarger = 1.5, kNoise_m = 5, kNoise_rad = 0.1;
  return a.lens == b.lens && b.region_radius_m <= kLarger * a.region_radius_m + kNoise_m &&
         b.region_angle_rad <= kLarger * a.region_angle_rad + kNoise_rad &&
         glm::distance(a.pose.eye, b.pose.eye) <= a.region_radius_m + b.region_radius_m && b.tau_px > 0.7 * a.tau_px &&
         glm::dot(a.pose.forward(), b.pose.forward()) > 0.9;
}

// Whether a page is there and its known nodes have the errors that the page says they were found to have at least; sets
// its radius.
bool isPossible(proto::KnownPage& page, const proto::StoredNodes& nodes, HeldPages* pages) {
  if (!nodes.hasPage(page.first) || (pages && !pages->need(page.first))) return false;
  bool is_possible = true;
  page.knowledge.known.forEach([&](uint8_t low) {
    const proto::NodeRecord& record = nodes[page.first | low];
    is_possible = is_possible && record.error() >= page.knowledge.finest;
    page.knowledge.radius = record.radius();
  });
  return is_possible;
}

}  // namespace

SectionSender::SectionSender(const Hierarchy& hierarchy) : hierarchy_(&hierarchy), adapter_(hierarchy.domain()) {
  makeObjects();
  setMemory(proto::kDefaultMemoryBytes);
  if (hierarchy.scene().supply()) pages_ = std::make_unique<HeldPages>(hierarchy);
  if (const terrain::EpochTable& table = hierarchy.epochs(); !table.epochs().empty()) {
    epochs_ = std::make_unique<proto::EpochStream>(hierarchy.grid(), table.epochs(), table.baseOffsets());
    scene_time_ = table.epochs().first();
  }
}

void SectionSender::makeObjects() {
  const proto::ObjectSet& set = hierarchy_->objects().set;
  objects_.clear();
  is_object_hidden_.assign(set.size(), 0);
  for (size_t i = 0; i < set.size(); ++i) objects_.emplace_back(set.domain(i));
  if (!objects_.empty()) stream_ = std::make_unique<proto::ObjectStream>(set);
}

void SectionSender::setMemory(uint32_t bytes) {
  adapter_.memory().pages.setBudget(bytes);
  if (stream_) stream_->setMemory(bytes);
}

bool SectionSender::resume(const proto::HeldSections& sections, uint32_t keyframe, Time time, uint32_t fingerprint) {
  std::vector<proto::KnownPage> known = sections.known;
  for (proto::KnownPage& page : known)
    if (!isPossible(page, hierarchy_->nodes(), pages_.get())) return false;
  proto::InMemoryNodes source = hierarchy_->source();
  proto::TerrainAdapter adapter(hierarchy_->domain(), sections.terrain.slots, source);
  adapter.memory().pages.setBudget(adapter_.memory().pages.budget());
  adapter.learn(known);
  adapter_ = std::move(adapter);
  const SceneObjects& objects = hierarchy_->objects();
  for (size_t i = 0; i < objects_.size(); ++i) {
    objects_[i] = proto::SurfaceAdapter(objects.set.domain(i), sections.objects[i].slots, objects.recordsOf(i));
    stream_->hold(i, sections.objects[i], objects.nodesOf(i));
  }
  keyframe_.index = keyframe;
  keyframe_.time = time;
  keyframe_.fingerprint = fingerprint;
  return true;
}

void SectionSender::restart() { restart(proto::Remembered::kPages); }

// The viewer forgets as much when it takes a keyframe from nothing.
void SectionSender::restart(proto::Remembered remembered) {
  const auto memory_bytes = static_cast<uint32_t>(adapter_.memory().pages.budget());
  remembered_ = remembered;
  adapter_.restart(remembered);
  if (remembered == proto::Remembered::kNothing) {
    model_.reset();
    if (epochs_) epochs_->restart();
  }
  makeObjects();
  setMemory(memory_bytes);
  keyframe_.fingerprint = 0;
  is_restarted_ = true;
}

bool SectionSender::isLikelyToFit(const proto::View& view, size_t max_nodes) const {
  return !startsFromNothing() && 2 * nodeCount() < max_nodes && isSimilar(proto::viewOf(keyframe_), view);
}

SectionSize SectionSender::measure(const proto::View& view, size_t max_nodes, SendScratch& scratch) const {
  const SectionSize too_large{.fits = false, .nodes = max_nodes, .added = max_nodes};
  if (!refine(*hierarchy_, view, max_nodes, scratch.refine, scratch.section, hiddenBlocks(), pages_.get()))
    return too_large;
  SectionSize size{.fits = true, .nodes = scratch.section.slots.size(), .added = 0};
  proto::KnownNodes known(adapter_);
  for (proto::Slot slot : scratch.section.slots) size.added += known.has(slot) ? 0 : 1;
  return measureObjects(view, max_nodes, scratch, size) ? size : too_large;
}

// Adds the objects' nodes to the size. False if there are more than `max_nodes` then.
bool SectionSender::measureObjects(const proto::View& view, size_t max_nodes, SendScratch& scratch,
                                   SectionSize& size) const {
  const auto newIn = [](const std::vector<proto::Slot>& slots, const auto& held) {
    return static_cast<size_t>(
        std::count_if(slots.begin(), slots.end(), [&](proto::Slot slot) { return !held.contains(slot); }));
  };
  const SceneObjects& objects = hierarchy_->objects();
  const proto::Frustum frustum(view, 0);
  for (size_t i = 0; i < objects_.size(); ++i) {
    if (is_object_hidden_[i] != 0 || !objects.mayBeSeen(i, view, frustum)) continue;
    proto::SurfaceAdapter fresh(objects.set.domain(i));
    std::span<const proto::SurfaceRecord> records = objects.recordsOf(i);
    scratch.object_delta = {};
    if (!fresh.adapt(objects.set.placement(i).toCarriedObject(view), max_nodes - size.nodes, records, scratch.adapt,
                     scratch.object_delta))
      return false;
    size.nodes += fresh.nodeCount();
    size.added += newIn(scratch.object_delta.added, objects_[i]);
  }
  return true;
}

double SectionSender::objectNodes(const proto::View& view, SendScratch& scratch) const {
  SectionSize size{.fits = true, .nodes = 0, .added = 0};
  CHECK_TRUE(measureObjects(view, std::numeric_limits<size_t>::max(), scratch, size));
  return static_cast<double>(size.nodes);
}

proto::SampledSize SectionSender::estimate(const proto::View& view, const proto::View& inner,
                                           SendScratch& scratch) const {
  proto::SampledSize size = estimateSize(*hierarchy_, view, inner, scratch.refine, hiddenBlocks(), pages_.get());
  size.nodes += objectNodes(view, scratch);
  size.within += objectNodes(inner, scratch);
  return size;
}

proto::SampledSize SectionSender::estimateWithin(const proto::View& inner, SendScratch& scratch) const {
  constexpr size_t kMost = 16, kFewest = 4096;  // one node in so many, but not fewer than so many
  const auto every = static_cast<uint32_t>(std::clamp<size_t>(adapter_.nodeCount() / kFewest, 1, kMost));
  std::vector<proto::Slot>& sample = scratch.section.slots;
  sample.clear();
  adapter_.sampleSection(every, [&](proto::Slot slot) { sample.push_back(slot); });
  const size_t needed = countNeeded(hierarchy_->domain(), hierarchy_->nodes(), inner, sample);
  const double of_terrain = static_cast<double>(adapter_.nodeCount()) * static_cast<double>(needed) /
                            static_cast<double>(std::max<size_t>(sample.size(), 1));
  return {static_cast<double>(nodeCount()), of_terrain + objectNodes(inner, scratch), sample.size()};
}

double SectionSender::toleranceThere(const proto::View& view, SendScratch& scratch) {
  return pages_ ? pages_->tolerance(view, scratch.refine, scratch.section) : view.tau_px;
}

bool SectionSender::send(const proto::View& view, Time time, size_t max_nodes, SendScratch& scratch, Bytes& out,
                         proto::BlockVisibility* visibility, ObjectVisibility* object_visibility) {
  scratch.delta.added.clear();
  scratch.delta.removed.clear();
  const proto::KeyframeHeader last = keyframe_;
  keyframe_.base_index = is_restarted_ ? 0 : keyframe_.index;
  ++keyframe_.index;
  keyframe_.time = time;
  keyframe_.lens = view.lens;
  keyframe_.tau_px = static_cast<float>(view.tau_px);
  keyframe_.region_radius_m = proto::shortAtLeast(view.region_radius_m);
  keyframe_.region_angle_rad = proto::shortAtLeast(view.region_angle_rad);
  keyframe_.pose = proto::asSentInHeader(view.pose);  // what the viewer decodes, and steps to
  keyframe_.scene_time = scene_time_;
  keyframe_.is_scene_step = is_scene_step_;

  Bytes delta;
  const proto::DenseNodes table = hierarchy_->table();
  if (!model_) model_ = std::make_unique<proto::DeltaModel>(proto::DeltaModel::forConnection(tells_blocks_));
  proto::DeltaEncoder encoder(hierarchy_->domain(), table, *model_, delta, visibility);
  if (keyframe_.base_index == 0) encoder.codeRestart(remembered_);
  if (visibility) visibility->begin(proto::viewOf(keyframe_));
  if (!adapter_.adapt(proto::viewOf(keyframe_), max_nodes, encoder, scratch.adapt, scratch.delta) ||
      !sendObjects(proto::viewOf(keyframe_), max_nodes, object_visibility, scratch, encoder.coder())) {
    keyframe_ = last;
    restart(proto::Remembered::kNothing);  // the step was not taken to its end
    return false;
  }
  if (epochs_)
    epochs_->encode(scene_time_, is_scene_step_, adapter_, scratch.delta.added, hierarchy_->epochs(), encoder.coder(),
                    epoch_bits_);
  bits_ = encoder.bits();
  keyframe_.fingerprint += proto::fingerprint(scratch.delta.added) - proto::fingerprint(scratch.delta.removed);
  encoder.finish();
  if (pages_) pages_->endKeyframe();
  is_restarted_ = false;

  proto::KeyframeHeader header = keyframe_;
  header.pose = view.pose;  // the encoder rounds it; rounding twice could differ
  const size_t begin = out.size();
  proto::encodeHeader(header, headers_sent_, out);
  header_bytes_ = out.size() - begin;
  out.insert(out.end(), delta.begin(), delta.end());
  return true;
}

// False if terrain and objects have more than `max_nodes`.
bool SectionSender::sendObjects(const proto::View& view, size_t max_nodes, ObjectVisibility* visibility,
                                SendScratch& scratch, proto::RangeEncoder& coder) {
  const SceneObjects& objects = hierarchy_->objects();
  object_bits_ = {};
  size_t others = nodeCount();  // of terrain, and objects but the one at hand
  const proto::Frustum frustum(view, 0);
  if (stream_) stream_->begin(view);
  for (size_t i = 0; i < objects_.size(); ++i) {
    proto::CutDelta& delta = scratch.object_delta;
    delta.added.clear();
    delta.removed.clear();
    const std::span<const proto::SurfaceRecord> records = objects.recordsOf(i);
    others -= objects_[i].nodeCount();
    // What is out of view and has no nodes gets none.
    const bool is_idle = objects_[i].nodeCount() == 0 && !objects.mayBeSeen(i, view, frustum);
    is_object_hidden_[i] = visibility && visibility->isObjectHidden(i, objects_[i].nodeCount()) ? 1 : 0;
    const auto isAdapted = [&] {
      return objects_[i].adapt(objects.set.placement(i).toCarriedObject(view), max_nodes - others, records,
                               scratch.adapt, delta);
    };
    if (is_object_hidden_[i] != 0)
      empty(i, delta);
    else if (others > max_nodes || (!is_idle && !isAdapted()))
      return false;
    others += objects_[i].nodeCount();
    stream_->encode(i, delta, objects.nodesOf(i), coder, object_bits_);
    keyframe_.fingerprint += proto::fingerprintOf(i, delta);
  }
  return others <= max_nodes;
}

// An object that stays its base mesh is not adapted, and begins anew when it is seen again.
void SectionSender::empty(size_t object, proto::CutDelta& delta) {
  if (objects_[object].nodeCount() == 0) return;
  delta.removed = objects_[object].section().slots;
  objects_[object] = proto::SurfaceAdapter(hierarchy_->objects().set.domain(object));
}

size_t SectionSender::hiddenObjects() const {
  return static_cast<size_t>(std::count(is_object_hidden_.begin(), is_object_hidden_.end(), 1));
}

size_t SectionSender::nodeCount() const {
  size_t count = adapter_.nodeCount();
  for (const proto::SurfaceAdapter& object : objects_) count += object.nodeCount();
  return count;
}

const proto::HiddenBlocks* SectionSender::hiddenBlocks() const {
  return adapter_.memory().hides ? &adapter_.memory().blocks : nullptr;
}

double SectionSender::triangles() const {
  double triangles = 2.0 * static_cast<double>(adapter_.nodeCount());
  const proto::ObjectSet& set = hierarchy_->objects().set;
  for (size_t i = 0; i < objects_.size(); ++i)
    triangles += set.domain(i).topology().base().faceCount() + 2.0 * static_cast<double>(objects_[i].nodeCount());
  return triangles;
}

}  // namespace foreland::server
