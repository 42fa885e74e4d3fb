// A store in memory whose moods a test chooses, and scenes that are read from it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "terrain/store/distant/sums.h"
#include "terrain/store/distant_scene.h"
#include "tests/support/files.h"
#include "tests/support/scene.h"

namespace foreland::test {

class FarStore final : public terrain::RangeSource {
 public:
  enum class Mood : uint8_t { kSound, kDead, kLying, kShort };

  explicit FarStore(const std::vector<char>& file) : file_(file.begin(), file.end()) {}
  Result<Bytes> read(uint64_t offset, uint64_t bytes) override {
    ++reads;
    const Mood now = mood;
    if (now == Mood::kDead || offset + bytes > file_.size()) return Error{ErrorCode::kIo, "the store is dead"};
    const auto begin = file_.begin() + static_cast<std::ptrdiff_t>(offset);
    Bytes result(begin, begin + static_cast<std::ptrdiff_t>(bytes));
    if (now == Mood::kLying) result[result.size() / 2] ^= 1;
    if (now == Mood::kShort) result.pop_back();
    return result;
  }

  std::atomic<Mood> mood{Mood::kSound};
  std::atomic<uint64_t> reads{0};

 private:
  const Bytes file_;
};

// A scene twice: on this machine, and in a store.
struct FarScene {
  std::shared_ptr<const terrain::Scene> here, there;
  std::shared_ptr<FarStore> store;

  terrain::ChunkCache& cache() const { return there->supply()->cache(); }
  // Fetches all that is wished for and has room, unless the store does not give it.
  void fetchAll() const {
    for (uint64_t before = ~uint64_t{0}; cache().counts().fetched != before;) {
      before = cache().counts().fetched;
      (void)cache().fetch();
    }
  }
};

inline FarScene farScene(const std::filesystem::path& path, uint64_t cache_bytes, uint64_t chunk_bytes = 4096) {
  FarScene scene;
  auto here = terrain::Scene::open(path);
  CHECK_TRUE(here.ok());
  scene.here = *here;
  scene.store = std::make_shared<FarStore>(slurp(path));
  const auto sums = terrain::sumsOf(path, chunk_bytes);
  CHECK_TRUE(sums.ok());
  auto there = terrain::openDistant(scene.store, encode(*sums), "far",
                                    {.cache_bytes = cache_bytes, .folder = path.parent_path(), .now = {}});
  if (!there.ok()) std::fprintf(stderr, "farScene: %s\n", there.error().message.c_str());
  CHECK_TRUE(there.ok());
  scene.there = *there;
  return scene;
}

inline FarScene farScene(uint32_t width, uint32_t height, uint64_t seed, uint64_t cache_bytes,
                         proto::FrameKind kind = proto::FrameKind::kPlanar) {
  const TemporaryFolder folder;
  FormulaSource source(width, height, hills(seed), kind);
  const auto path = folder / "scene.fls";
  CHECK_TRUE(terrain::buildScene(source, {.output = path, .height_quantum_m = 0.1, .threads = 1}).ok());
  return farScene(path, cache_bytes);
}

}  // namespace foreland::test
