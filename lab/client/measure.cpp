#include "lab/client/measure.h"

#include <algorithm>
#include <numeric>

#include "base/check.h"
#include "base/quantile.h"
#include "lab/client/mesh_client.h"
#include "server/session/world.h"
#include "sim/thread_time.h"

namespace foreland::lab {

namespace {

constexpr int kMeshPasses = 3;

// Times of one keyframe by pass.
struct PassTimes {
  std::vector<double> decode_s, mesh_s, full_mesh_s;
};

template <class Work>
void timed(std::vector<double>& seconds, const Work& work) {
  const double began = sim::threadSeconds();
  work();
  seconds.push_back(sim::threadSeconds() - began);
}

size_t changesOf(const client::Replica& replica) {
  size_t changes = replica.lastDelta().added.size() + replica.lastDelta().removed.size();
  for (const client::ObjectReplica& object : replica.objects()) changes += object.morphs().all().size();
  return changes;
}

void stepByChange(MeshClient& client, const RecordedKeyframe& recorded, PassTimes& times, KeyframeCosts& k) {
  CHECK_TRUE(client.read(recorded.message));
  timed(times.decode_s, [&] { CHECK_TRUE(client.decode()); });
  timed(times.mesh_s, [&] { client.patch(); });
  client.collect();
  k.triangles = client.triangles();
  k.changes = changesOf(client.replica());
  k.upload_bytes = client.uploadBytes();
  k.uploads = client.uploads();
  k.whole_bytes = client.wholeBytes();
}

void stepAnew(MeshClient& client, const RecordedKeyframe& recorded, PassTimes& times, const KeyframeCosts& k) {
  CHECK_TRUE(client.read(recorded.message) && client.decode());
  timed(times.full_mesh_s, [&] { CHECK_EQ(client.buildAnew(), k.triangles); });
}

template <class Value>
std::vector<double> valuesOf(const std::vector<KeyframeCosts>& all, const Value& value) {
  std::vector<double> values;
  for (size_t i = 1; i < all.size(); ++i) values.push_back(static_cast<double>(value(all[i])));
  return values;
}

double sumOf(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

}  // namespace

ClientCosts costsOf(const std::vector<KeyframeCosts>& all, double memory_bytes) {
  using K = KeyframeCosts;
  const auto decode_ms = valuesOf(all, [](const K&k) { return 1e3 * k.decode_s; }),
             mesh_ms = valuesOf(all, [](const K&k) { return 1e3 * k.mesh_s; }),
             full_ms = valuesOf(all, [](const K&k) { return 1e3 * k.full_mesh_s; }),
             triangles = valuesOf(all, [](const K&k) { return k.triangles; }),
             changes = valuesOf(all, [](const K&k) { return k.changes; }),
             upload = valuesOf(all, [](const K&k) { return k.upload_bytes; }),
             uploads = valuesOf(all, [](const K&k) { return k.uploads; }),
             whole = valuesOf(all, [](const K&k) { return k.whole_bytes; });
  const double count = std::max(1.0, static_cast<double>(mesh_ms.size()));
  ClientCosts costs{.keyframes = all.size(), .mesh_memory_bytes = memory_bytes};
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

ClientMeasurement measureClient(const server::Hierarchy& hierarchy, const std::vector<RecordedKeyframe>& flight) {
  std::vector<KeyframeCosts> all(flight.size());
  std::vector<PassTimes> times(flight.size());
  size_t memory_bytes = 0;
  for (int pass = 0; pass < kMeshPasses; ++pass) {
    MeshClient by_change(server::welcomeTo(hierarchy)), anew(server::welcomeTo(hierarchy));
    for (size_t i = 0; i < flight.size(); ++i) stepByChange(by_change, flight[i], times[i], all[i]);
    for (size_t i = 0; i < flight.size(); ++i) stepAnew(anew, flight[i], times[i], all[i]);
    memory_bytes = by_change.wholeBytes() + by_change.replica().patcherBytes();
  }
  for (size_t i = 0; i < flight.size(); ++i) {
    all[i].decode_s = median(times[i].decode_s);
    all[i].mesh_s = median(times[i].mesh_s);
    all[i].full_mesh_s = median(times[i].full_mesh_s);
  }
  return {all, costsOf(all, static_cast<double>(memory_bytes))};
}

}  // namespace foreland::lab
