#include "tests/fuzz/changed_file.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "base/check.h"
#include "terrain/store/format.h"
#include "terrain/surface_store/surface_format.h"

namespace foreland::test {

namespace {

using terrain::FileHeader;
using terrain::kPageBytes;
using terrain::SurfaceHeader;

constexpr size_t kLongestPlace = 512;  // bytes of a section that changes reach
constexpr uint8_t kWholeFile = 255, kCut = 255, kLeaveChecksums = 0x40;

template <class Header>
Header headerAt(ByteSpan file, size_t at) {
  Header header;
  std::memcpy(&header, file.data() + at, sizeof(header));
  return header;
}

// Calls visit(header, offset) for the header of each file that begins at a page, files within files included.
template <class Visit>
void forEachHeader(ByteSpan file, const Visit& visit) {
  for (size_t at = 0; at + kPageBytes <= file.size(); at += kPageBytes) {
    const auto begins = [&](const std::array<char, 8>& magic) {
      return std::memcmp(file.data() + at, magic.data(), magic.size()) == 0;
    };
    if (begins(terrain::kSceneMagic)) visit(headerAt<FileHeader>(file, at), at);
    if (begins(terrain::kSurfaceMagic)) visit(headerAt<SurfaceHeader>(file, at), at);
  }
}

// Sets the id and the checksum of a header right.
template <class Header>
void seal(const PageBytes& file, Header header, size_t at) {
  const ByteSpan own = file.span().subspan(at);
  const terrain::SectionRange& table = *(std::end(header.sections) - 1);
  if (table.offset <= own.size() && table.bytes <= own.size() - table.offset)
    header.scene_id = terrain::contentId(header, own.subspan(table.offset, table.bytes));
  header.header_checksum = terrain::headerChecksum(header);
  std::memcpy(file.data() + at, &header, sizeof(header));
}

}  // namespace

PageBytes::PageBytes(ByteSpan content) : size_(content.size()) {
  void* memory = nullptr;
  CHECK_EQ(posix_memalign(&memory, kPageBytes, std::max<size_t>(size_, 1)), 0);
  data_.reset(static_cast<uint8_t*>(memory));
  if (size_ > 0) std::memcpy(memory, content.data(), size_);
}

void PageBytes::Free::operator()(uint8_t* data) const { std::free(data); }

SoundFile::SoundFile(Bytes bytes) : bytes_(std::move(bytes)) {
  forEachHeader(bytes_, [&](const auto& header, size_t at) {
    places_.push_back({at, sizeof(header)});
    for (const terrain::SectionRange& section : header.sections)
      if (section.bytes > 0) places_.push_back({at + section.offset, std::min<size_t>(section.bytes, kLongestPlace)});
    if constexpr (requires { header.epochs; })
      if (header.epochs.bytes > 0)
        places_.push_back({at + header.epochs.offset, std::min<size_t>(header.epochs.bytes, kLongestPlace)});
    if constexpr (requires { header.tiles; })
      if (header.tiles.bytes > 0)
        places_.push_back({at + header.tiles.offset, std::min<size_t>(header.tiles.bytes, kLongestPlace)});
    if constexpr (requires { header.pages; })
      if (header.pages.bytes > 0)
        places_.push_back({at + header.pages.offset, std::min<size_t>(header.pages.bytes, kLongestPlace)});
  });
  CHECK_GT(places_.size(), 1u);
}

std::shared_ptr<const PageBytes> SoundFile::changed(ByteSpan changes, bool keeps_checksums) const {
  Bytes bytes = bytes_;
  size_t size = bytes.size();
  while (changes.size() >= 4) {
    const size_t offset = changes[1] | changes[2] << 8;
    const size_t count = std::min<size_t>(changes[3] % 16 + 1, changes.size() - 4);
    if (changes[0] == kCut) {
      size = std::min(size, offset);
    } else {
      const Place& place = places_[changes[0] % places_.size()];
      const size_t begin = place.offset + offset % place.bytes;
      std::copy_n(changes.begin() + 4, std::min(count, bytes.size() - begin),
                  bytes.begin() + static_cast<ptrdiff_t>(begin));
    }
    changes = changes.subspan(4 + (changes[0] == kCut ? 0 : count));
  }
  auto file = std::make_shared<const PageBytes>(ByteSpan(bytes).first(size));
  if (!keeps_checksums) forEachHeader(file->span(), [&](const auto& header, size_t at) { seal(*file, header, at); });
  return file;
}

std::shared_ptr<const PageBytes> fileOf(ByteSpan input, std::span<const SoundFile> files) {
  if (input.empty()) return std::make_shared<const PageBytes>(input);
  if (input[0] == kWholeFile) return std::make_shared<const PageBytes>(input.subspan(1));
  return files[input[0] % kLeaveChecksums % files.size()].changed(input.subspan(1), input[0] & kLeaveChecksums);
}

}  // namespace foreland::test
