// The earth that a globe is built of is ETOPO20 above EGM96 as a second reader of both files finds it, which shares no
// code with ours: netCDF's classic format and NOAA's GTX are read here byte by byte.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <vector>

#include "base/rng.h"
#include "terrain/dem/open_globe.h"
#include "tests/support/data.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

class BigEndian {
 public:
  explicit BigEndian(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
  }
  bool isEmpty() const { return bytes_.empty(); }
  double float64(size_t at) const { return std::bit_cast<double>(word(at, 8)); }
  double float32(size_t at) const { return std::bit_cast<float>(static_cast<uint32_t>(word(at, 4))); }
  uint32_t uint32(size_t at) const { return static_cast<uint32_t>(word(at, 4)); }

 private:
  uint64_t word(size_t at, size_t size) const {
    uint64_t value = 0;
    for (size_t i = 0; i < size; ++i) value = value << 8 | static_cast<uint8_t>(bytes_.at(at + i));
    return value;
  }
  std::vector<char> bytes_;
};

// Where the variables begin in this file, as its header says: longitudes, latitudes and heights, row by row.
struct Etopo {
  BigEndian file;
  static constexpr size_t kColumns = 1080, kStored = 1081, kRows = 540, kLongitudes = 584, kLatitudes = 9232,
                          kHeights = 13552;

  double at(size_t column, size_t row) const {
    return file.float32(kHeights + 4 * (row * kStored + column % kColumns));
  }
  double meanOf(size_t row) const {
    double sum = 0;
    for (size_t column = 0; column < kColumns; ++column) sum += at(column, row);
    return sum / kColumns;
  }
  double along(double longitude, size_t row) const {
    const double step = 360.0 / kColumns, from = longitude - file.float64(kLongitudes),
                 x = (from - 360 * std::floor(from / 360)) / step, left = std::floor(x);
    return std::lerp(at(static_cast<size_t>(left), row), at(static_cast<size_t>(left) + 1, row), x - left);
  }
  double metres(double latitude, double longitude) const {
    const double south = file.float64(kLatitudes), north = file.float64(kLatitudes + 8 * (kRows - 1));
    if (latitude < south) return std::lerp(meanOf(0), along(longitude, 0), (latitude + 90) / (south + 90));
    if (latitude > north)
      return std::lerp(meanOf(kRows - 1), along(longitude, kRows - 1), (90 - latitude) / (90 - north));
    const double y = std::min((latitude - south) / (north - south) * (kRows - 1), kRows - 1.001);
    const auto row = static_cast<size_t>(y);
    return std::lerp(along(longitude, row), along(longitude, row + 1), y - static_cast<double>(row));
  }
};

struct Geoid96 {
  BigEndian file;

  double at(size_t column, size_t row) const { return file.float32(40 + 4 * (row * 1440 + column % 1440)); }
  double metres(double latitude, double longitude) const {
    const double y = std::min((latitude + 90) * 4, 719.9999999), x = (longitude + 180) * 4;
    const auto row = static_cast<size_t>(y), column = static_cast<size_t>(x);
    const double u = x - static_cast<double>(column);
    return std::lerp(std::lerp(at(column, row), at(column + 1, row), u),
                     std::lerp(at(column, row + 1), at(column + 1, row + 1), u), y - static_cast<double>(row));
  }
};

TEST(EarthSources, AreWhatASecondReaderFinds) {
  FORELAND_DATA_OR_SKIP(relief, "dem/global/etopo20.cdf");
  const Etopo etopo{BigEndian(relief)};
  const Geoid96 geoid{BigEndian("/usr/share/proj/egm96_15.gtx")};
  ASSERT_FALSE(geoid.file.isEmpty()) << "package proj-data";
  ASSERT_EQ(geoid.file.uint32(32), 721u);
  ASSERT_EQ(geoid.file.uint32(36), 1440u);
  OpenOptions options;
  options.vertical = "egm96";
  const auto earth = openGlobe({relief}, options);
  ASSERT_TRUE(earth.ok()) << earth.error().message;
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  for (int i = 0; i < 100'000; ++i) {
    const double latitude = std::asin(rng.uniform(-1, 1)), longitude = rng.uniform(-std::numbers::pi, std::numbers::pi);
    const glm::dvec3 direction(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                               std::sin(latitude));
    constexpr double kDegree = std::numbers::pi / 180;
    const double expected =
        etopo.metres(latitude / kDegree, longitude / kDegree) + geoid.metres(latitude / kDegree, longitude / kDegree);
    ASSERT_NEAR((*earth)->heightAt(direction).metres, expected, 2e-3)
        << "seed " << seed << ", at " << latitude / kDegree << ", " << longitude / kDegree;
  }
}

}  // namespace
}  // namespace foreland::terrain
