#include "bench/client/measure.h"

#include <algorithm>

#include "base/check.h"
#include "bench/client/mesh_client.h"
#include "bench/timing.h"
#include "server/session/world.h"

namespace foreland::bench {

namespace {

constexpr int kPasses = 3;

struct Keyframe {
  std::vector<double> decode_s, mesh_s, full_s;  // by pass
  size_t triangles = 0, changes = 0, upload_bytes = 0, uploads = 0, whole_bytes = 0;
};

template <class Work>
void timed(std::vector<double>& seconds, const Work& work) {
  const double began = threadSeconds();
  work();
  seconds.push_back(threadSeconds() - began);
}

size_t changesOf(const client::Replica& replica) {
  size_t changes = replica.lastDelta().added.size() + replica.lastDelta().removed.size();
  for (const client::ObjectReplica& object : replica.objects()) changes += object.morphs().all().size();
  return changes;
}

void stepByChange(MeshClient& client, const RecordedKeyframe& recorded, Keyframe& k) {
  CHECK_TRUE(client.read(recorded.message));
  timed(k.decode_s, [&] { CHECK_TRUE(client.decode()); });
  timed(k.mesh_s, [&] { client.patch(); });
  client.collect();
  k.triangles = client.triangles();
  k.changes = changesOf(client.replica());
  k.upload_bytes = client.uploadBytes();
  k.uploads = client.uploads();
  k.whole_bytes = client.wholeBytes();
}

void stepAnew(MeshClient& client, const RecordedKeyframe& recorded, Keyframe& k) {
  CHECK_TRUE(client.read(recorded.message) && client.decode());
  timed(k.full_s, [&] { CHECK_EQ(client.buildAnew(), k.triangles); });
}

template <class Value>
std::vector<double> valuesOf(const std::vector<Keyframe>& all, const Value& value) {
  std::vector<double> values;
  for (size_t i = 1; i < all.size(); ++i) values.push_back(value(all[i]));
  return values;
}

double sumOf(const std::vector<double>& values) {
  double sum = 0;
  for (double v : values) sum += v;
  return sum;
}

ClientCosts costsOf(const std::vector<Keyframe>& all) {
  const auto decode_ms = valuesOf(all, [](const Keyframe&k) { return 1e3 * median(k.decode_s); }),
             mesh_ms = valuesOf(all, [](const Keyframe&k) { return 1e3 * median(k.mesh_s); }),
             full_ms = valuesOf(all, [](const Keyframe&k) { return 1e3 * median(k.full_s); }),
             triangles = valuesOf(all, [](const Keyframe&k) { return static_cast<double>(k.triangles); }),
             changes = valuesOf(all, [](const Keyframe&k) { return static_cast<double>(k.changes); }),
             upload = valuesOf(all, [](const Keyframe&k) { return static_cast<double>(k.upload_bytes); }),
             uploads = valuesOf(all, [](const Keyframe&k) { return static_cast<double>(k.uploads); }),
             whole = valuesOf(all, [](const Keyframe&k) { return static_cast<double>(k.whole_bytes); });
  const double count = std::max(1.0, static_cast<double>(mesh_ms.size()));
  ClientCosts costs{.keyframes = all.size()};
  costs.triangles = sumOf(triangles) / count;
  costs.changes = sumOf(changes) / count;
  costs.mesh_ms_p50 = median(mesh_ms);
  costs.mesh_ms_p99 = quantile(mesh_ms, 0.99);
  costs.mesh_us_per_change = 1e3 * sumOf(mesh_ms) / std::max(1.0, sumOf(changes));
  costs.full_mesh_ms = median(full_ms);
  costs.mesh_ratio = costs.full_mesh_ms / std::max(1e-9, costs.mesh_ms_p50);
  costs.upload_bytes_p50 = median(upload);
  costs.upload_share = sumOf(upload) / std::max(1.0, sumOf(whole));
  costs.uploads_p50 = median(uploads);
  costs.decode_ms_p50 = median(decode_ms);
  return costs;
}

}  // namespace

ClientCosts measureClient(const server::Hierarchy& hierarchy, const std::vector<RecordedKeyframe>& flight) {
  std::vector<Keyframe> all(flight.size());
  size_t memory_bytes = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    MeshClient by_change(server::welcomeTo(hierarchy)), anew(server::welcomeTo(hierarchy));
    for (size_t i = 0; i < flight.size(); ++i) stepByChange(by_change, flight[i], all[i]);
    for (size_t i = 0; i < flight.size(); ++i) stepAnew(anew, flight[i], all[i]);
    memory_bytes = by_change.wholeBytes() + by_change.replica().patcherBytes();
  }
  ClientCosts costs = costsOf(all);
  costs.mesh_memory_bytes = static_cast<double>(memory_bytes);
  return costs;
}

}  // namespace foreland::bench
