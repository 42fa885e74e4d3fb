// A valid file and a fuzzer's changes to it. The checksums are corrected after the changes, so that a short input
// reaches the code behind the checksums, and no change is wasted on the zeros that fill pages. The input:
//
//   1 byte       255: the rest is the whole file, unchanged. Otherwise the number of a valid file (modulo how many there
//                are); bit 6 leaves the checksums wrong
//   changes      part (1), offset (2, little-endian), count (1), then count % 16 + 1 bytes that replace those there
//
// A part is a header or the beginning of a section, of the file or of one within it; offsets are modulo its size.
// Part 255 truncates the file to `offset` bytes instead. Not thread-safe.
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
