#include "server/section/sender.h"

#include <algorithm>

namespace foreland::server {

namespace {

// Whether the section of `b` is at most about twice that of `a`: the regions meet, and tolerance and direction differ
// little.
bool isSimilar(const proto::View& a, const proto::View& b) {
  return a.lens == b.lens && glm::distance(a.pose.eye, b.pose.eye) <= a.region_radius_m + b.region_radius_m &&
         b.tau_px > 0.7 * a.tau_px && glm::dot(a.pose.forward(), b.pose.forward()) > 0.9;
}

// Whether the known nodes of a page have the errors that the page says they were found to have at least; sets its
// radius.
bool isPossible(proto::KnownPage& page, std::span<const proto::NodeRecord> nodes) {
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
  const proto::ObjectSet& set = hierarchy.objects().set;
  for (size_t i = 0; i < set.size(); ++i) objects_.emplace_back(set.domain(i));
  if (!objects_.empty()) stream_ = std::make_unique<proto::ObjectStream>(set);
  setMemory(proto::kDefaultMemoryBytes);
}

void SectionSender::setMemory(uint32_t bytes) {
  adapter_.memory().pages.setBudget(bytes);
  if (stream_) stream_->setMemory(bytes);
}

bool SectionSender::resume(const proto::HeldSections& sections, uint32_t keyframe, Time time, uint32_t fingerprint) {
  std::vector<proto::KnownPage> known = sections.known;
  for (proto::KnownPage& page : known)
    if (!isPossible(page, hierarchy_->nodes())) return false;
  proto::InMemoryNodes source = hierarchy_->source();
  proto::TerrainAdapter adapter(hierarchy_->domain(), sections.terrain.slots, source);
  adapter.memory().pages.setBudget(adapter_.memory().pages.budget());
  adapter.learn(known);
  adapter_ = std::move(adapter);
  const SceneObjects& objects = hierarchy_->objects();
  for (size_t i = 0; i < objects_.size(); ++i) {
    objects_[i] = proto::SurfaceAdapter(objects.set.domain(i), sections.objects[i].slots, objects.recordsOf(i));
    stream_->hold(i, sections.objects[i], objects.recordsOf(i));
  }
  keyframe_.index = keyframe;
  keyframe_.time = time;
  keyframe_.fingerprint = fingerprint;
  return true;
}

bool SectionSender::fitsSurely(const proto::View& view, size_t max_nodes) const {
  return keyframe_.index > 0 && 2 * adapter_.nodeCount() < max_nodes && isSimilar(proto::viewOf(keyframe_), view);
}

SectionSize SectionSender::measure(const proto::View& view, size_t max_nodes, SendScratch& scratch) const {
  if (!refine(*hierarchy_, view, max_nodes, scratch.refine, scratch.section, hiddenBlocks()))
    return {.fits = false, .added = max_nodes};
  const auto& slots = scratch.section.slots;
  const auto is_new = [&](proto::Slot slot) { return !adapter_.knows(slot); };
  return {.fits = true, .added = static_cast<size_t>(std::count_if(slots.begin(), slots.end(), is_new))};
}

void SectionSender::send(const proto::View& view, Time time, SendScratch& scratch, Bytes& out,
                         proto::BlockVisibility* visibility) {
  scratch.delta.added.clear();
  scratch.delta.removed.clear();
  keyframe_.base_index = keyframe_.index++;
  keyframe_.time = time;
  keyframe_.lens = view.lens;
  keyframe_.tau_px = static_cast<float>(view.tau_px);
  keyframe_.region_radius_m = proto::shortAtLeast(view.region_radius_m);
  keyframe_.region_angle_rad = proto::shortAtLeast(view.region_angle_rad);
  keyframe_.pose = proto::asSentInHeader(view.pose);  // what the viewer decodes, and steps to

  Bytes delta;
  const proto::DenseNodes table = hierarchy_->table();
  proto::DeltaEncoder encoder(hierarchy_->domain(), table, model_, delta, visibility);
  if (visibility) visibility->begin(proto::viewOf(keyframe_));
  CHECK_TRUE(
      adapter_.adapt(proto::viewOf(keyframe_), hierarchy_->grid().slotCount(), encoder, scratch.adapt, scratch.delta));
  bits_ = encoder.bits();
  keyframe_.fingerprint += proto::fingerprint(scratch.delta.added) - proto::fingerprint(scratch.delta.removed);
  sendObjects(proto::viewOf(keyframe_), scratch, encoder.coder());
  encoder.finish();

  proto::KeyframeHeader header = keyframe_;
  header.pose = view.pose;  // the encoder rounds it; rounding twice could differ
  const size_t begin = out.size();
  proto::encodeHeader(header, headers_sent_, out);
  header_bytes_ = out.size() - begin;
  out.insert(out.end(), delta.begin(), delta.end());
}

void SectionSender::sendObjects(const proto::View& view, SendScratch& scratch, proto::RangeEncoder& coder) {
  const SceneObjects& objects = hierarchy_->objects();
  object_bits_ = {};
  if (stream_) stream_->begin(view);
  for (size_t i = 0; i < objects_.size(); ++i) {
    proto::CutDelta& delta = scratch.object_delta;
    delta.added.clear();
    delta.removed.clear();
    const std::span<const proto::SurfaceRecord> records = objects.recordsOf(i);
    CHECK_TRUE(objects_[i].adapt(objects.set.placement(i).toObject(view), objects.set.domain(i).topology().slotCount(),
                                 records, scratch.adapt, delta));
    stream_->encode(i, delta, records, coder, object_bits_);
    keyframe_.fingerprint += proto::fingerprintOf(i, delta);
  }
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
