#include "terrain/dem/mosaic/overlap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace foreland::terrain {

namespace {

constexpr double kFeet = 1 / 0.3048;
constexpr double kMostUndulation_m = 120;  // the earth's geoids are within 107 m of the ellipsoid
constexpr double kAlike_m = 5;             // how much a difference of datums varies over a scene

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool isAbout(double value, double wanted) { return std::fabs(value / wanted - 1) < 0.03; }

// By how much one number is larger than the other.
std::optional<std::string> wrongUnit(double ratio) {
  static constexpr const char* kConvert = "; convert it first with gdal_translate -ot Float32 -scale 0 1 0 0.3048";
  if (isAbout(ratio, kFeet)) return std::string("the second is likely in feet, which it does not state") + kConvert;
  if (isAbout(ratio, 1 / kFeet)) return std::string("the first is likely in feet, which it does not state") + kConvert;
  for (const double power : {10.0, 100.0, 1000.0}) {
    if (isAbout(ratio, power))
      return fmt::format("the numbers of the second are {:g} times as large: another unit", power);
    if (isAbout(ratio, 1 / power))
      return fmt::format("the numbers of the first are {:g} times as large: another unit", power);
  }
  return std::nullopt;
}

}  // namespace

void Overlap::keep(float first_m, float second_m) {
  pairs_.push_back({first_m, second_m});
  if (pairs_.size() < kMostPairs) return;
  for (size_t i = 0; 2 * i < pairs_.size(); ++i) pairs_[i] = pairs_[2 * i];
  pairs_.resize(pairs_.size() / 2);
  stride_ *= 2;
}

std::optional<std::string> Overlap::doubt() const {
  if (pairs_.size() < kFewestPairs) return std::nullopt;
  std::vector<double> differences, ratios, spreads;
  for (const Pair& p : pairs_) {
    differences.push_back(double{p.second_m} - p.first_m);
    if (std::fabs(p.first_m) > 1) ratios.push_back(double{p.second_m} / p.first_m);
  }
  const double difference_m = median(differences);
  if (std::fabs(difference_m) <= kDoubtful_m) return std::nullopt;
  const std::string found = fmt::format("the second is {:.0f} m {} in the median; ", std::fabs(difference_m),
                                        difference_m > 0 ? "higher" : "lower");
  if (!ratios.empty())
    if (const auto unit = wrongUnit(median(ratios))) return found + *unit;
  for (const double d : differences) spreads.push_back(std::fabs(d - difference_m));
  if (median(spreads) > kAlike_m) return found + "they are not of the same ground: see their places and their units";
  if (std::fabs(difference_m) <= kMostUndulation_m)
    return found +
           "nearly the same everywhere, as between a geoid and the ellipsoid: likely another vertical datum "
           "(FILE@vertical=ellipsoid or egm96)";
  return found + "nearly the same everywhere: heights from another zero, which no geoid explains";
}

}  // namespace foreland::terrain
