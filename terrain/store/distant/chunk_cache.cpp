#include "terrain/store/distant/chunk_cache.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <bitset>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "base/check.h"
#include "terrain/store/file/spool_file.h"

namespace foreland::terrain {

namespace {

constexpr size_t kMostInRun = ReadPace::kMostChunks;  // chunks that one read fetches
constexpr size_t kMostWishes = 256;                   // of one owner
constexpr Duration kFirstPause = Duration::milliseconds(100), kLongestPause = Duration::milliseconds(5000);
constexpr std::chrono::milliseconds kLookAgain{50};  // while what is wished for may not be tried yet

Error ofCache(const std::filesystem::path& folder, const std::string& what) {
  return {ErrorCode::kIo, "the cache of a scene at a distance, in " + folder.string() + ": " + what +
                              "; give it another folder (--store-cache-dir), or less (--store-cache-mib)"};
}

Error fromSystem(const std::filesystem::path& folder, const char* doing) {
  return ofCache(folder, std::string(doing) + ": " + std::strerror(errno));
}

Duration pauseAfter(int tries) {
  return std::min(kFirstPause * (int64_t{1} << std::min(tries - 1, 10)), kLongestPause);
}

}  // namespace

Result<std::shared_ptr<ChunkCache>> ChunkCache::create(SceneSums sums, std::shared_ptr<RangeSource> source,
                                                       ChunkCacheOptions options) {
  std::shared_ptr<ChunkCache> cache(new ChunkCache(std::move(sums), std::move(source), std::move(options)));
  if (Status s = cache->reserve(); !s.ok()) return s.error();
  return cache;
}

ChunkCache::ChunkCache(SceneSums sums, std::shared_ptr<RangeSource> source, ChunkCacheOptions options)
    : sums_(std::move(sums)), source_(std::move(source)), options_(std::move(options)), pace_(sums_.chunk_bytes) {}

Status ChunkCache::reserve() {
  if (sums_.sums.empty() || sums_.sums.size() > std::numeric_limits<Chunk>::max())
    return ofCache(options_.folder, "the scene has no chunks, or too many");
  capacity_ = std::max<uint64_t>(1, (options_.cache_bytes + sums_.chunk_bytes - 1) / sums_.chunk_bytes);
  rlimit limit{};  // beyond which a signal would end the program
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && sums_.file_bytes > limit.rlim_cur)
    return ofCache(options_.folder, "files may not be as large as the scene (ulimit -f)");
  file_ = openUnnamed(options_.folder);
  if (file_ < 0) return fromSystem(options_.folder, "cannot create a file");
  if (::ftruncate(file_, static_cast<off_t>(sums_.file_bytes)) != 0)
    return fromSystem(options_.folder, "cannot make a file as large as the scene, with holes");
  if (::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(sums_.chunk_bytes)) != 0)
    return fromSystem(options_.folder, "its file system makes no holes in files");
  void* data = ::mmap(nullptr, sums_.file_bytes, PROT_READ, MAP_SHARED | MAP_NORESERVE, file_, 0);
  if (data == MAP_FAILED) return fromSystem(options_.folder, "cannot map it");
  data_ = static_cast<const uint8_t*>(data);
  ::madvise(data, sums_.file_bytes, MADV_RANDOM);  // what lies beside is mostly a hole
  states_ = std::make_unique<State[]>(sums_.sums.size());
  return {};
}

ChunkCache::~ChunkCache() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  changed_.notify_all();
  source_->stop();
  threads_.clear();  // joins
  if (data_) ::munmap(const_cast<uint8_t*>(data_), sums_.file_bytes);
  if (file_ >= 0) ::close(file_);
}

bool ChunkCache::hold(Chunk chunk) {
  State& state = states_[chunk];
  int32_t holders = state.holders.load(std::memory_order_acquire);
  while (holders != kAbsent) {
    if (!state.holders.compare_exchange_weak(holders, holders + 1, std::memory_order_acquire)) continue;
    if (holders == 0) held_.fetch_add(1, std::memory_order_relaxed);
    uses_.fetch_add(1, std::memory_order_relaxed);
    return true;
  }
  return false;
}

void ChunkCache::release(Chunk chunk) {
  State& state = states_[chunk];
  touch(state);
  const int32_t before = state.holders.fetch_sub(1, std::memory_order_release);
  DCHECK_GE(before, 1);
  if (before == 1) held_.fetch_sub(1, std::memory_order_relaxed);
}

void ChunkCache::touch(State& state) {
  state.used_at.store(clock_.fetch_add(1, std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

Status ChunkCache::keep(uint64_t offset, uint64_t bytes) {
  if (bytes == 0) return {};
  const Chunk last = chunkAt(offset + bytes - 1);
  for (Chunk chunk = chunkAt(offset); chunk <= last;) {
    if (hold(chunk)) {
      ++chunk, ++kept_;
      continue;
    }
    std::vector<Chunk> run;
    while (chunk <= last && isAbsent(chunk) &&
           (run.empty() || (run.size() + 1) * sums_.chunk_bytes <= ReadPace::kMostBytes))
      run.push_back(chunk++);
    const std::lock_guard lock(mutex_);
    if (kept_ + run.size() > (capacity_ + 1) / 2 || !makeRoom(run.size()))
      return Error{ErrorCode::kLimit,
                   "the cache of a scene at a distance is too small: what is always needed of this one takes more than "
                   "half of " +
                       std::to_string((capacity_ * sums_.chunk_bytes) >> 20) +
                       " MiB; give it more (--store-cache-mib)"};
    const ReadPace::Read read = pace_.begin(bytesOf(run), now());
    const Status status = fetch(run);
    pace_.end(read, status.ok(), now());
    if (!status.ok()) return status;
    for (const Chunk each : run) {
      arrived(each);
      CHECK_TRUE(hold(each));
    }
    kept_ += run.size();
  }
  return {};
}

ChunkCache::Wishes::Wishes(ChunkCache& cache) : cache_(cache) {
  const std::lock_guard lock(cache_.mutex_);
  at_ = cache_.wishes_.emplace(cache_.wishes_.end());
}

ChunkCache::Wishes::~Wishes() {
  const std::lock_guard lock(cache_.mutex_);
  cache_.wishes_.erase(at_);
}

void ChunkCache::Wishes::set(std::vector<Wish> wishes) {
  const auto held = cache_.held_.load(std::memory_order_relaxed);
  const size_t room = cache_.capacity_ > held ? cache_.capacity_ - held : 0, most = std::min(kMostWishes, room);
  if (wishes.size() > most) {
    std::nth_element(wishes.begin(), wishes.begin() + static_cast<std::ptrdiff_t>(most), wishes.end(),
                     [](const Wish& a, const Wish& b) { return a.error_px > b.error_px; });
    wishes.resize(most);
  }
  const bool wants_any = !wishes.empty();
  {
    const std::lock_guard lock(cache_.mutex_);
    at_->swap(wishes);
  }
  if (wants_any) cache_.changed_.notify_all();
}

// The chunk that is wished for most, then its wished neighbours on both sides, as many as the store gives soon.
std::vector<ChunkCache::Chunk> ChunkCache::choose() {
  const Time at = now();
  const size_t most = pace_.chunks();
  if (most == 0 || store_.next > at) return {};
  const auto mayBeTried = [&](Chunk chunk) {
    if (!isAbsent(chunk) || in_flight_.contains(chunk)) return false;
    const auto failing = failing_.find(chunk);
    return failing == failing_.end() || failing->second.next <= at;
  };
  std::optional<Wish> best;
  for (const std::vector<Wish>& each : wishes_)
    for (const Wish& wish : each)
      if ((!best || wish.error_px > best->error_px) && mayBeTried(wish.chunk)) best = wish;
  if (!best) return {};
  std::bitset<2 * kMostInRun> is_wished;  // of the chunks about the best, which is number kMostInRun
  for (const std::vector<Wish>& each : wishes_)
    for (const Wish& wish : each)
      if (const int64_t number = int64_t{wish.chunk} - int64_t{best->chunk} + int64_t{kMostInRun};
          number >= 0 && number < int64_t{2 * kMostInRun} && mayBeTried(wish.chunk))
        is_wished.set(static_cast<size_t>(number));
  size_t begin = kMostInRun, end = kMostInRun + 1;
  while (end < is_wished.size() && is_wished[end] && end - begin < most) ++end;
  while (begin > 0 && is_wished[begin - 1] && end - begin < most) --begin;
  std::vector<Chunk> run;
  for (size_t i = begin; i < end; ++i) run.push_back(static_cast<Chunk>(best->chunk + i - kMostInRun));
  return run;
}

// Evicts what nobody holds or wishes for, the longest unused first; a few more than needed, since it looks at all. What
// is wished for has just come, and its viewer will hold it; without it the wishes of several viewers that do not fit
// together would be fetched in place of one another without end.
bool ChunkCache::makeRoom(size_t chunks) {
  const uint64_t wanted = there_.size() + in_flight_.size() + chunks;
  if (wanted <= capacity_) return true;
  const size_t needed = wanted - capacity_;
  std::unordered_set<Chunk> wished;
  for (const std::vector<Wish>& each : wishes_)
    for (const Wish& wish : each) wished.insert(wish.chunk);
  const auto isFree = [&](Chunk chunk) {
    return states_[chunk].holders.load(std::memory_order_relaxed) == 0 && !wished.contains(chunk);
  };
  const auto begin_free = std::partition(there_.begin(), there_.end(), [&](Chunk chunk) { return !isFree(chunk); });
  const auto free = static_cast<size_t>(there_.end() - begin_free);
  if (free < needed) return false;
  const size_t victims = std::min(free, std::max<size_t>(needed, capacity_ / 64));
  std::vector<std::pair<uint64_t, Chunk>> by_use;
  for (auto it = begin_free; it != there_.end(); ++it) by_use.emplace_back(states_[*it].used_at.load(), *it);
  std::nth_element(by_use.begin(), by_use.begin() + static_cast<std::ptrdiff_t>(victims) - 1, by_use.end());
  size_t evicted = 0;
  for (size_t i = 0; i < victims; ++i) {
    const Chunk chunk = by_use[i].second;
    int32_t nobody = 0;
    if (!states_[chunk].holders.compare_exchange_strong(nobody, kAbsent, std::memory_order_acq_rel)) continue;
    ::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(sums_.begin(chunk)),
                static_cast<off_t>(sums_.chunk_bytes));
    ++evicted;
  }
  std::erase_if(there_, [&](Chunk chunk) { return isAbsent(chunk); });
  counts_.evicted += evicted;
  return evicted >= needed;
}

bool ChunkCache::fetch() {
  std::unique_lock lock(mutex_);
  std::vector<Chunk> run = choose();
  if (run.empty()) return false;
  if (!makeRoom(run.size())) {
    ++counts_.no_room;
    return false;
  }
  in_flight_.insert(run.begin(), run.end());
  const ReadPace::Read read = pace_.begin(bytesOf(run), now());
  lock.unlock();
  const Status status = fetch(run);
  lock.lock();
  pace_.end(read, status.ok(), now());
  end(run, status);
  return true;
}

uint64_t ChunkCache::bytesOf(const std::vector<Chunk>& run) const {
  return sums_.begin(run.back()) + sums_.bytesOf(run.back()) - sums_.begin(run.front());
}

// Reads chunks that follow one another and puts those in place that are sound.
Status ChunkCache::fetch(const std::vector<Chunk>& run) {
  const uint64_t begin = sums_.begin(run.front()), bytes = bytesOf(run);
  const auto read = source_->read(begin, bytes);
  if (!read) return read.error();
  if (read->size() != bytes)
    return Error{ErrorCode::kIo, "the store gave " + std::to_string(read->size()) + " bytes for " +
                                     std::to_string(bytes) + "; copy the scene there again"};
  Status status;
  for (const Chunk chunk : run)
    if (Status s = put(chunk, ByteSpan(*read).subspan(sums_.begin(chunk) - begin, sums_.bytesOf(chunk))); !s.ok())
      status = s;
  return status;
}

Status ChunkCache::put(Chunk chunk, ByteSpan bytes) {
  if (!sums_.isSound(chunk, bytes))
    return Error{ErrorCode::kMalformed, "the store's bytes from " + std::to_string(sums_.begin(chunk)) +
                                            " on are not those that `foreland sums` saw; copy the scene there again"};
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t n =
        ::pwrite(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(sums_.begin(chunk) + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return fromSystem(options_.folder, "cannot write");
    done += static_cast<size_t>(n);
  }
  touch(states_[chunk]);
  states_[chunk].holders.store(0, std::memory_order_release);
  return {};
}

void ChunkCache::arrived(Chunk chunk) {
  there_.push_back(chunk);
  ++counts_.fetched;
  counts_.fetched_bytes += sums_.bytesOf(chunk);
}

// Takes in how fetching went.
void ChunkCache::end(const std::vector<Chunk>& run, const Status& status) {
  for (const Chunk chunk : run) {
    in_flight_.erase(chunk);
    if (!isAbsent(chunk)) {
      arrived(chunk);
      failing_.erase(chunk);
      continue;
    }
    Trouble& trouble = failing_[chunk];
    ++trouble.tries;
    if (options_.now) trouble.next = now() + pauseAfter(trouble.tries);
  }
  noteStore(status);
}

// A chunk that is not sound says nothing of the store's other chunks; a read that failed does.
void ChunkCache::noteStore(const Status& status) {
  const bool is_unsound = !status.ok() && status.error().code == ErrorCode::kMalformed;
  if (!status.ok()) ++(is_unsound ? counts_.unsound : counts_.failed);
  if (is_unsound && counts_.unsound == 1) options_.tell(status.error().message);
  if (status.ok() && store_.tries > 0) options_.tell("the store answers again");
  if (status.ok() || is_unsound) {
    store_ = {};
    return;
  }
  if (options_.now && now() < store_.next) return;  // was under way when another one failed
  if (++store_.tries == 1) options_.tell(status.error().message + "; the scene stays as coarse as what is there");
  if (options_.now) store_.next = now() + pauseAfter(store_.tries);
}

void ChunkCache::start(unsigned threads) {
  for (unsigned i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
}

void ChunkCache::run() {
  while (true) {
    if (fetch()) continue;
    std::unique_lock lock(mutex_);
    if (stops_) return;
    const bool is_wished = std::ranges::any_of(wishes_, [](const auto& wishes) { return !wishes.empty(); });
    if (is_wished)
      changed_.wait_for(lock, kLookAgain);
    else
      changed_.wait(lock);
    if (stops_) return;
  }
}

double ChunkCache::bytesPerSecond() const {
  const std::lock_guard lock(mutex_);
  return pace_.bytesPerSecond();
}

ChunkCache::Counts ChunkCache::counts() const {
  const std::lock_guard lock(mutex_);
  Counts counts = counts_;
  counts.capacity = capacity_;
  counts.there = there_.size();
  counts.held = held_.load(std::memory_order_relaxed);
  counts.uses = uses_.load(std::memory_order_relaxed);
  for (const std::vector<Wish>& each : wishes_) counts.wished += each.size();
  return counts;
}

}  // namespace foreland::terrain
