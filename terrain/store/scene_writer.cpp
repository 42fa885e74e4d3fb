#include "terrain/store/scene_writer.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "terrain/store/checksum.h"

namespace foreland::terrain {

namespace {

std::filesystem::path folderOf(const std::filesystem::path& target) {
  return target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
}

// A hidden name beside the target that no other process uses.
std::filesystem::path hiddenName(const std::filesystem::path& target) {
  static std::atomic<uint32_t> counter{0};
  std::string name(".");  // appended to: g++ 12 warns falsely of operator+ here
  name += target.filename().string();
  name += '.' + std::to_string(::getpid()) + '-' + std::to_string(counter++) + ".part";
  return folderOf(target) / name;
}

Status checkTarget(const std::filesystem::path& target) {
  struct stat about {};
  if (target.filename().empty() || (::stat(target.c_str(), &about) == 0 && !S_ISREG(about.st_mode)))
    return Error{ErrorCode::kInvalidArgument,
                 target.string() + ": not a file that can be written; name a file to create, as scene.fls"};
  return {};
}

}  // namespace

Error SceneWriter::systemError(const std::string& doing) const {
  const std::string why = std::strerror(errno);
  const std::string way_out = errno == ENOSPC || errno == EFBIG || errno == EDQUOT
                                  ? "; the scene needs " + std::to_string((layout_.file_bytes >> 20) + 1) + " MiB"
                                  : "";
  return {ErrorCode::kIo, target_.string() + ": " + doing + ": " + why + way_out};
}

Result<SceneWriter> SceneWriter::create(const std::filesystem::path& target, const About& about) {
  auto grid = proto::GridTopology::create(about.shape);
  if (!grid.ok()) return grid.error();
  if (Status frame = about.frame.validate(grid->maxX(), grid->maxY()); !frame.ok()) return frame.error();
  const Bytes text = encodeText(about.origin);
  if (text.size() > kMaxTextBytes)
    return Error{ErrorCode::kLimit, target.string() + ": more than 16 MiB of names and notes"};

  SceneWriter writer;
  writer.target_ = target;
  writer.layout_ = FileLayout::of(*grid, text.size());
  FileHeader& h = writer.header_;
  h.file_bytes = writer.layout_.file_bytes;
  const proto::GridShape& s = about.shape;
  h.roots_x = s.roots_x, h.roots_y = s.roots_y, h.root_log2 = s.root_log2, h.samples_x = s.samples_x,
  h.samples_y = s.samples_y;
  putFrame(about.frame, h);
  h.lowest = about.heights.lowest, h.highest = about.heights.highest;
  h.voids_filled = about.origin.voids_filled;
  h.slot_count = grid->slotCount();
  for (uint32_t kind = 0; kind < kSectionCount; ++kind) h.sections[kind] = writer.layout_.sections[kind];

  if (Status status = checkTarget(target); !status.ok()) return status.error();
  if (Status status = writer.openTemporary(); !status.ok()) return status.error();
  if (Status status = writer.reserve(); !status.ok()) return status.error();
  std::memcpy(writer.at(kText), text.data(), text.size());
  return writer;
}

SceneWriter::SceneWriter(SceneWriter&& other) noexcept
    : target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      file_(std::exchange(other.file_, -1)),
      data_(std::exchange(other.data_, nullptr)),
      layout_(other.layout_),
      header_(other.header_) {}

SceneWriter::~SceneWriter() {
  if (data_) ::munmap(data_, layout_.file_bytes);
  if (file_ >= 0) ::close(file_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Status SceneWriter::openTemporary() {
  constexpr int kMode = 0666;  // as the umask allows
  file_ = ::open(folderOf(target_).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, kMode);
  if (file_ >= 0) return {};
  if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL) return systemError("cannot create it");
  const auto hidden = hiddenName(target_);
  file_ = ::open(hidden.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, kMode);
  if (file_ < 0) return systemError("cannot create it");
  temporary_ = hidden;
  return {};
}

Status SceneWriter::reserve() {
  // A file size limit would send a signal instead of an error.
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      layout_.file_bytes > limit.rlim_cur) {
    errno = EFBIG;
    return systemError("cannot reserve its space");
  }
  if (const int error = ::posix_fallocate(file_, 0, static_cast<off_t>(layout_.file_bytes)); error != 0) {
    errno = error;
    return systemError("cannot reserve its space");
  }
  void* data = ::mmap(nullptr, layout_.file_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  if (data == MAP_FAILED) return systemError("cannot map it");
  data_ = static_cast<uint8_t*>(data);
  return {};
}

std::span<const NodeRecord> SceneWriter::nodes() const {
  return {reinterpret_cast<const NodeRecord*>(at(kNodes)), layout_.sections[kNodes].bytes / sizeof(NodeRecord)};
}
std::span<int32_t> SceneWriter::corners() {
  return {reinterpret_cast<int32_t*>(at(kCorners)), layout_.sections[kCorners].bytes / sizeof(int32_t)};
}
std::span<int32_t> SceneWriter::centres() {
  return {reinterpret_cast<int32_t*>(at(kCentres)), layout_.sections[kCentres].bytes / sizeof(int32_t)};
}

Status SceneWriter::put(proto::Slot first, std::span<const NodeRecord> records) const {
  const auto bytes = std::as_bytes(records);
  const uint64_t offset = layout_.sections[kNodes].offset + static_cast<uint64_t>(first) * sizeof(NodeRecord);
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t written =
        ::pwrite(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return systemError("cannot write it");
    done += static_cast<size_t>(written);
  }
  return {};
}

void SceneWriter::release(std::span<const NodeRecord> nodes) const {
  const auto begin = (reinterpret_cast<uintptr_t>(nodes.data()) + kPageBytes - 1) & ~(kPageBytes - 1);
  const auto end = reinterpret_cast<uintptr_t>(nodes.data() + nodes.size()) & ~(kPageBytes - 1);
  if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
}

Result<uint64_t> SceneWriter::finish() {
  const SectionPlace& place = layout_.sections[kChecksums];
  const ByteSpan file(data_, layout_.file_bytes);
  auto* table = reinterpret_cast<uint64_t*>(at(kChecksums));
  for (uint64_t i = 0; i < blockCount(place); ++i) {
    const ByteSpan block = blockAt(file, place, i);
    table[i] = xxh64(block);
    ::madvise(const_cast<uint8_t*>(block.data()), block.size(), MADV_DONTNEED);
  }
  header_.scene_id = contentId(header_, file.subspan(place.offset, place.bytes));
  header_.header_checksum = headerChecksum(header_);
  std::memcpy(data_, &header_, sizeof(header_));
  if (::msync(data_, layout_.file_bytes, MS_SYNC) != 0 || ::fsync(file_) != 0) return systemError("cannot write it");
  if (Status status = name(); !status.ok()) return status.error();
  return header_.scene_id;
}

// An unnamed file can be linked only where nothing is, so it passes through the hidden name for an instant.
Status SceneWriter::name() {
  if (temporary_.empty()) {
    const auto hidden = hiddenName(target_);
    const std::string unnamed = "/proc/self/fd/" + std::to_string(file_);
    if (::linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, hidden.c_str(), AT_SYMLINK_FOLLOW) != 0)
      return systemError("cannot name it");
    temporary_ = hidden;
  }
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) return systemError("cannot name it");
  temporary_.clear();
  if (const int folder = ::open(folderOf(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); folder >= 0) {
    ::fsync(folder);  // best effort: the file itself is safe already
    ::close(folder);
  }
  return {};
}

}  // namespace foreland::terrain
