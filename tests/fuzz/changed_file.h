// A sound file and what a fuzzer changes in it, after which the checksums are set right again: so an input of some
// bytes reaches what stands behind the checksums, and none go into the zeros that fill pages. The input:
//
//   1 byte       255: the rest is the whole file, as it is. Else which sound file (modulo their number);
//                with bit 6 the checksums are left wrong
//   changes      place (1), offset (2, little-endian), count (1), then count % 16 + 1 bytes that go there
//
// A place is a header or the begin of a section, of the file or of one within it; offsets are modulo its size. The
// place 255 cuts the file to `offset` bytes instead. Not thread-safe.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "base/bytes.h"

namespace foreland::test {

// Bytes that begin at a page, as a mapped file does, and end where a sanitizer watches.
class PageBytes {
 public:
  explicit PageBytes(ByteSpan content);
  uint8_t* data() const { return data_.get(); }
  ByteSpan span() const { return {data_.get(), size_}; }

 private:
  struct Free {
    void operator()(uint8_t* data) const;
  };
  std::unique_ptr<uint8_t[], Free> data_;
  size_t size_;
};

// A scene's or a surface's file, and where its headers and sections are.
class SoundFile {
 public:
  explicit SoundFile(Bytes bytes);

  // `changes` as above, without the first byte.
  std::shared_ptr<const PageBytes> changed(ByteSpan changes, bool keeps_checksums) const;

 private:
  struct Place {
    size_t offset, bytes;
  };

  Bytes bytes_;
  std::vector<Place> places_;
};

// What an input stands for; `files` are the sound ones, at least one.
std::shared_ptr<const PageBytes> fileOf(ByteSpan input, std::span<const SoundFile> files);

// Some small ones of each kind, through the real builders: every rule and frame, with and without image and objects.
const std::vector<SoundFile>& soundScenes();
const std::vector<SoundFile>& soundSurfaces();

}  // namespace foreland::test
