// Elevation data as the builder sees it: a raster of heights on a lattice, and the frame of that lattice. Implemented
// by terrain/dem (files) and by tests (formulas). One owner; readRows may be called from one thread at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "proto/section/epochs.h"
#include "proto/space/frame.h"
#include "proto/space/vertical.h"

namespace foreland::terrain {

inline constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();

// One of the inputs that a source is put together from.
struct ElevationInput {
  std::string name;             // the file
  proto::LatticeWindow window;  // of the source's samples
  std::string vertical;         // what its heights counted from; empty if that is not stated
  bool may_have_voids = false;  // that later inputs fill
  bool is_on_lattice = true;    // whether its samples are where the source's are
  // Else by how much the source differs from it at its samples at most, where it alone counts: further than feather_m
  // from its edges, and where nothing lies over it. Metres; not a number if that is not known.
  double residual_m = std::numeric_limits<double>::quiet_NaN();
  double feather_m = 0;
};

struct ElevationInfo {
  uint32_t width = 0;              // samples along lattice x
  uint32_t height = 0;             // samples along lattice y
  proto::Frame frame;              // lattice (0, 0) is the south-west sample; the builder chooses its height quantum
  std::string title;               // file names, for people
  std::string crs_wkt;             // empty if none
  std::vector<std::string> notes;  // what was assumed about the input, a sentence each
  proto::VerticalDatum vertical{};
  uint64_t voids_filled = 0;  // by the source
  // Where `vertical` is stated, or grids differ: the first that has data at a sample counts.
  std::vector<ElevationInput> inputs{};
};

// Heights on a lattice that is fine in places, and between these as bisection draws coarser ones. Any thread.
class SparseHeights {
 public:
  virtual ~SparseHeights() = default;
  // Heights that lie 2^wholeLog2() apart are there everywhere.
  virtual uint32_t wholeLog2() const = 0;
  // Whether heights that lie `spacing` or less apart are there in a part of a window, which may reach beyond the
  // lattice.
  virtual bool isFineIn(uint32_t spacing, const proto::LatticeWindow& window) const = 0;
  // At any position of the lattice, metres.
  virtual double heightAt(uint32_t x, uint32_t y) const = 0;
  // The source's inputs with their residuals against another surface on the lattice, metres.
  virtual std::vector<ElevationInput> inputsAgainst(
      const std::function<double(uint32_t x, uint32_t y)>& surface) const = 0;
};

class ElevationSource {
 public:
  virtual ~ElevationSource() = default;
  virtual const ElevationInfo& info() const = 0;
  // Heights in metres of `count` rows from lattice row `first` (0 is the southernmost), each `width` samples from the
  // west; kVoid where the source has no data. `out` holds count * width values.
  virtual Status readRows(uint32_t first, uint32_t count, std::span<float> out) = 0;
  // Not null where the lattice is to be fine in places only, and would be far too large to read all of it.
  virtual const SparseHeights* sparse() const { return nullptr; }
  // What the rows that were read make doubtful, a sentence each.
  virtual std::vector<std::string> warnings() const { return {}; }
};

}  // namespace foreland::terrain
