// A file at a distance, as one on this machine of which not all is there: an address range of the file's size, in a
// sparse temporary file of bounded size. Chunks that somebody wishes for are fetched, held against their checksums
// (sums.h) and put in their places; whichever was not used for longest makes room, unless it is held or wished for.
//
// Readers take no lock and wait for nothing: hold() says whether a chunk is there, and until release() it stays. What
// is not held must not be read. fetch() is called by threads of the cache's own (start()), or by a test.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "terrain/store/distant/range_source.h"
#include "terrain/store/distant/read_pace.h"
#include "terrain/store/distant/sums.h"

namespace foreland::terrain {

struct ChunkCacheOptions {
  uint64_t cache_bytes = uint64_t{1} << 30;  // rounded up to chunks
  std::filesystem::path folder;              // of the temporary file
  std::function<Time()> now;  // when what failed is tried again, and how quick the store is; without it, at once, very
  std::function<void(const std::string&)> tell = [](const std::string&) {};  // that fetching fails, or works again
};

class ChunkCache {
 public:
  using Chunk = uint32_t;
  // The larger the error on somebody's screen, the sooner it is fetched.
  struct Wish {
    Chunk chunk = 0;
    float error_px = 0;
  };
  struct Counts {
    uint64_t capacity = 0, held = 0;  // chunks that may be there, and that somebody holds
    uint64_t there = 0, wished = 0;   // chunks
    uint64_t uses = 0;                // times that somebody began to hold one
    uint64_t fetched = 0, fetched_bytes = 0, evicted = 0;
    uint64_t failed = 0, unsound = 0;  // reads that failed; chunks that were not what their checksums say
    uint64_t no_room = 0;              // times that nothing could be fetched: all that is there is held or wished for
  };

  static Result<std::shared_ptr<ChunkCache>> create(SceneSums sums, std::shared_ptr<RangeSource> source,
                                                    ChunkCacheOptions options);
  ~ChunkCache();
  ChunkCache(const ChunkCache&) = delete;
  ChunkCache& operator=(const ChunkCache&) = delete;

  const SceneSums& sums() const { return sums_; }
  // All of the file's addresses.
  ByteSpan file() const { return {data_, sums_.file_bytes}; }
  Chunk chunkAt(uint64_t offset) const { return static_cast<Chunk>(offset / sums_.chunk_bytes); }

  // Whether the chunk is there; if it is, it stays until release(), once for each hold().
  [[nodiscard]] bool hold(Chunk chunk);
  void release(Chunk chunk);

  // How many chunks somebody holds, and how many there may be. Without a lock.
  struct Use {
    uint64_t held, capacity;
  };
  Use use() const { return {held_.load(std::memory_order_relaxed), capacity_}; }

  // Fetches what lacks of a part of the file, at once, and holds it for good. An Error if it cannot, or if more than
  // half the cache would be held.
  Status keep(uint64_t offset, uint64_t bytes);

  // What somebody would like to be there; of chunks that are, nothing. One owner, and the cache outlives it.
  class Wishes {
   public:
    explicit Wishes(ChunkCache& cache);
    Wishes(const Wishes&) = delete;
    Wishes& operator=(const Wishes&) = delete;
    ~Wishes();
    // In place of what was wished for before. No more are kept than fit in the cache beside what is held.
    void set(std::vector<Wish> wishes);

   private:
    ChunkCache& cache_;
    std::list<std::vector<Wish>>::iterator at_;
  };

  // Fetches the chunk that is wished for most and may be tried now, with as many wished neighbours as the store gives
  // soon (read_pace.h). False if there is none, no room, or enough is under way.
  bool fetch();
  // Starts threads that fetch until the cache is destroyed.
  void start(unsigned threads);

  Counts counts() const;
  // Of the store, as measured; 0 before the first read.
  double bytesPerSecond() const;

 private:
  static constexpr int32_t kAbsent = -1;
  struct State {
    std::atomic<int32_t> holders{kAbsent};  // 0: there, and may be evicted
    std::atomic<uint64_t> used_at{0};
  };
  struct Trouble {
    int tries = 0;
    Time next;
  };

  ChunkCache(SceneSums sums, std::shared_ptr<RangeSource> source, ChunkCacheOptions options);
  Status reserve();
  std::vector<Chunk> choose();
  bool makeRoom(size_t chunks);
  uint64_t bytesOf(const std::vector<Chunk>& run) const;
  Status fetch(const std::vector<Chunk>& run);
  Status put(Chunk chunk, ByteSpan bytes);
  void arrived(Chunk chunk);
  void touch(State& state);
  void end(const std::vector<Chunk>& run, const Status& status);
  void noteStore(const Status& status);
  void run();
  bool isAbsent(Chunk chunk) const { return states_[chunk].holders.load(std::memory_order_acquire) == kAbsent; }
  Time now() const { return options_.now ? options_.now() : Time{}; }

  const SceneSums sums_;
  const std::shared_ptr<RangeSource> source_;
  const ChunkCacheOptions options_;
  uint64_t capacity_ = 0;  // chunks
  int file_ = -1;
  const uint8_t* data_ = nullptr;
  std::unique_ptr<State[]> states_;
  std::atomic<uint64_t> clock_{0};  // of uses
  std::atomic<uint64_t> held_{0}, uses_{0};

  mutable std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::list<std::vector<Wish>> wishes_;
  std::vector<Chunk> there_;  // in no order
  std::unordered_map<Chunk, Trouble> failing_;
  std::unordered_set<Chunk> in_flight_;  // for which there is room
  Trouble store_;                        // since the last read that succeeded
  ReadPace pace_;
  uint64_t kept_ = 0;
  Counts counts_;
  bool stops_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace foreland::terrain
