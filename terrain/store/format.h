// The scene file's bytes: one page of header, then page-aligned sections whose sizes follow from the grid's shape.
// Described for readers of other languages in docs/SCENE_FORMAT.md; change both, and kFormatVersion, together. Pure;
// any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/section/page_directory.h"
#include "proto/space/frame.h"
#include "proto/topology/grid.h"
#include "terrain/store/file/sections.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

inline constexpr std::array<char, 8> kSceneMagic{'F', 'O', 'R', 'E', 'L', 'A', 'N', 'D'};
inline constexpr uint32_t kFormatVersion = 8;

enum SectionKind : uint32_t { kText, kCorners, kCentres, kNodes, kObjects, kChecksums, kSectionCount };

// How the records of nodes stand in the file: as they are in memory, or coded (coded/group_codec.h).
enum class PageCoding : uint32_t { kPlain, kCoded };

// The start of the file's first page; the rest of the page is zero.
struct FileHeader {
  static constexpr uint32_t kOldestVersion = 3;    // had no tiles; the reader still takes it
  static constexpr uint32_t kLinearVersion = 4;    // epochs were blended linearly; written for scenes whose are
  static constexpr uint32_t kUnstatedVersion = 5;  // no vertical datum is stated; written for scenes whose is not
  static constexpr uint32_t kWholeVersion = 6;     // all levels are whole; written for scenes whose are
  static constexpr uint32_t kPlainVersion = 7;     // pages are not coded; written for scenes whose are not

  std::array<char, 8> magic = kSceneMagic;
  uint32_t version = kFormatVersion;
  uint32_t byte_order = kByteOrderMark;
  uint64_t file_bytes = 0;
  uint64_t scene_id = 0;  // XXH64 of this page with scene_id and header_checksum zero, then of the checksum table
  uint64_t header_checksum = 0;  // XXH64 of this page with header_checksum zero
  uint32_t roots_x = 0, roots_y = 0, root_log2 = 0, samples_x = 0, samples_y = 0;
  uint32_t frame_kind = 0;
  double height_quantum_m = 0;
  double anchor[2]{}, axis_x_m[2]{}, axis_y_m[2]{}, map_origin_m[2]{};
  double latitude0_rad = 0, longitude0_rad = 0, latitude_step_rad = 0, longitude_step_rad = 0;
  double semi_major_m = 0, flattening = 0;
  double origin_latitude_rad = 0, origin_longitude_rad = 0, origin_height_m = 0;
  int32_t lowest = 0, highest = 0;
  uint64_t voids_filled = 0;
  uint64_t slot_count = 0;
  SectionRange sections[kSectionCount];
  SectionRange epochs;       // after the objects (epoch_section.h); zeros in scenes without epochs
  SectionRange tiles;        // after the epochs (tile_section.h); zeros in scenes without tiles
  uint32_t epoch_blend = 0;  // proto::EpochBlend
  uint32_t sparse_levels = 0;
  SectionRange datum;  // after the tiles (datum_section.h); zeros where no vertical datum is stated
  SectionRange pages;  // after the datum: blocks of the pages that are there of sparse levels; zeros if there are none
  PageCoding page_coding = PageCoding::kPlain;
  uint32_t has_sea = 0;  // 1: viewers draw the sea over the ground of a globe that is below it

  proto::GridShape shape() const {
    const bool is_cube = frame_kind == static_cast<uint32_t>(proto::FrameKind::kGlobe);
    return {roots_x, roots_y, root_log2, samples_x, samples_y, sparse_levels, is_cube};
  }
};
static_assert(sizeof(FileHeader) == 408 && std::is_trivially_copyable_v<FileHeader>);
static_assert(offsetof(FileHeader, roots_x) == 40 && offsetof(FileHeader, height_quantum_m) == 64);
static_assert(offsetof(FileHeader, lowest) == 208 && offsetof(FileHeader, sections) == 232);

// Where the sections of a file lie, given its pages and the sizes of those that do not follow from it.
struct FileLayout {
  struct Sizes {
    uint64_t text = 0, objects = 0, epochs = 0, tiles = 0, datum = 0;
    uint64_t coded_pages = 0;  // 0 where pages are not coded
  };
  std::array<SectionRange, kSectionCount> sections;
  SectionRange epochs, tiles, datum, pages;  // zeros if there are none
  uint64_t file_bytes = 0;
  // The directory says how many records there are, where pages are not coded.
  static FileLayout of(const proto::GridShape& shape, const proto::PageDirectory& directory, const Sizes& bytes);
};

void putFrame(const proto::Frame& frame, FileHeader& header);
proto::Frame getFrame(const FileHeader& header);

Bytes encodeText(const SceneOrigin& origin);
Status decodeText(ByteSpan bytes, SceneOrigin& origin);

}  // namespace foreland::terrain
