#include "terrain/store/mapped_scene.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace foreland::terrain {

namespace {

Error fromSystem(const std::filesystem::path& path) {
  const ErrorCode code = errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
  return {code, path.string() + ": " + std::strerror(errno) +
                    (code == ErrorCode::kNotFound ? "; `foreland build` makes a scene" : "")};
}

Error damaged(const std::filesystem::path& path, const std::string& what) {
  return {ErrorCode::kMalformed, path.string() + ": " + what + "; build or copy the scene again"};
}

// Maps a whole regular file of at least one page, or says why not.
Result<ByteSpan> mapFile(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return fromSystem(path);
  struct stat about {};
  void* data = MAP_FAILED;
  Status status;
  if (::fstat(file, &about) != 0) {
    status = fromSystem(path);
  } else if (!S_ISREG(about.st_mode)) {
    status = Error{ErrorCode::kInvalidArgument, path.string() + ": not a file; name a scene made by `foreland build`"};
  } else if (static_cast<uint64_t>(about.st_size) < kPageBytes) {
    status = Error{ErrorCode::kMalformed, path.string() + ": not a scene (only " + std::to_string(about.st_size) +
                                              " bytes); name a file made by `foreland build`"};
  } else {
    data = ::mmap(nullptr, static_cast<size_t>(about.st_size), PROT_READ, MAP_SHARED, file, 0);
    if (data == MAP_FAILED) status = fromSystem(path);
  }
  ::close(file);
  if (!status.ok()) return status.error();
  return ByteSpan(static_cast<const uint8_t*>(data), static_cast<size_t>(about.st_size));
}

Result<FileHeader> readHeader(ByteSpan file, const std::filesystem::path& path) {
  FileHeader header;
  std::memcpy(&header, file.data(), sizeof(header));
  if (header.magic != kSceneMagic)
    return Error{ErrorCode::kMalformed, path.string() + ": not a scene; name a file made by `foreland build`"};
  if (header.byte_order != kByteOrderMark)
    return Error{ErrorCode::kUnsupported, path.string() + ": written with another byte order; build the scene again"};
  if (header.version != kFormatVersion)
    return Error{ErrorCode::kUnsupported, path.string() + ": scene format " + std::to_string(header.version) +
                                              ", this program reads " + std::to_string(kFormatVersion) +
                                              "; build the scene again"};
  if (header.header_checksum != headerChecksum(header)) return damaged(path, "its header is damaged");
  for (size_t i = sizeof(header); i < kPageBytes; ++i)
    if (file[i] != 0) return damaged(path, "its header is damaged");
  if (header.file_bytes != file.size())
    return damaged(
        path, "it should have " + std::to_string(header.file_bytes) + " bytes but has " + std::to_string(file.size()));
  return header;
}

}  // namespace

Result<std::shared_ptr<const MappedScene>> MappedScene::open(const std::filesystem::path& path) {
  const auto file = mapFile(path);
  if (!file.ok()) return file.error();
  const auto fail = [&](Error error) {
    ::munmap(const_cast<uint8_t*>(file->data()), file->size());
    return error;
  };
  const auto header = readHeader(*file, path);
  if (!header.ok()) return fail(header.error());
  auto grid = proto::GridTopology::create(
      {header->roots_x, header->roots_y, header->root_log2, header->samples_x, header->samples_y});
  if (!grid.ok()) return fail(damaged(path, grid.error().message));
  std::shared_ptr<MappedScene> scene(new MappedScene(*file, *header, *grid));
  if (const Status status = scene->adopt(); !status.ok()) return damaged(path, status.error().message);
  return std::shared_ptr<const MappedScene>(std::move(scene));
}

MappedScene::MappedScene(ByteSpan file, const FileHeader& header, proto::GridTopology grid)
    : Scene(std::move(grid), getFrame(header)), file_(file), header_(header) {}

MappedScene::~MappedScene() { ::munmap(const_cast<uint8_t*>(file_.data()), file_.size()); }

template <class T>
std::span<const T> MappedScene::section(SectionKind kind) const {
  const SectionPlace& place = header_.sections[kind];
  return {reinterpret_cast<const T*>(file_.data() + place.offset), place.bytes / sizeof(T)};
}

std::span<const uint64_t> MappedScene::blockChecksums() const { return section<uint64_t>(kChecksums); }

// Checks what the header says against what it must say, then points the spans into the file.
Status MappedScene::adopt() {
  const auto malformed = [](const char* what) { return Error{ErrorCode::kMalformed, what}; };
  if (Status frame = frame_.validate(grid_.maxX(), grid_.maxY()); !frame.ok()) return frame;
  const uint64_t text_bytes = header_.sections[kText].bytes;
  if (text_bytes > kMaxTextBytes) return malformed("its text is too long");
  const FileLayout layout = FileLayout::of(grid_, text_bytes);
  for (uint32_t kind = 0; kind < kSectionCount; ++kind)
    if (header_.sections[kind] != layout.sections[kind]) return malformed("its sections are not where they belong");
  if (header_.file_bytes != layout.file_bytes || header_.slot_count != grid_.slotCount() ||
      header_.lowest > header_.highest)
    return malformed("its sizes contradict each other");
  const auto table = section<uint8_t>(kChecksums);
  if (contentId(header_, table) != header_.scene_id) return malformed("its table of checksums is damaged");

  if (Status text = decodeText(section<uint8_t>(kText), origin_); !text.ok()) return text;
  origin_.voids_filled = header_.voids_filled;
  id_ = header_.scene_id;
  heights_ = {header_.lowest, header_.highest};
  nodes_ = section<NodeRecord>(kNodes);
  corners_ = section<int32_t>(kCorners);
  centres_ = section<int32_t>(kCentres);
  return {};
}

}  // namespace foreland::terrain
