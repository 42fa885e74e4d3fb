// IGC flight recorder files (FAI technical specification, appendix A): B records are fixes, an I record says where in
// them the further digits of latitude and longitude stand (LAD, LOD). Other records are not needed.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "base/lines.h"
#include "client/fly/tracks/track.h"
#include "client/fly/tracks/track_builder.h"

namespace foreland::client {

namespace {

constexpr double kDay_s = 86'400;

// Columns, counted from 1 as in the specification; 0 means absent.
struct Extensions {
  size_t latitude_first = 0, latitude_last = 0;
  size_t longitude_first = 0, longitude_last = 0;
};

struct BRecord {
  double day_s = 0;
  double latitude_deg = 0, longitude_deg = 0;
  double pressure_height_m = 0, gps_height_m = 0;
  bool is_three_dimensional = false;
  size_t line = 0;
};

std::optional<int> number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<int> digits(std::string_view text) {
  return text.find_first_not_of("0123456789") == std::string_view::npos ? number(text) : std::nullopt;
}

// "I" count of extensions (2 digits), then first column, last column (2 digits each) and a three-letter code.
Extensions parseExtensions(std::string_view line) {
  Extensions result;
  for (size_t at = 3; at + 7 <= line.size(); at += 7) {
    const auto first = digits(line.substr(at, 2)), last = digits(line.substr(at + 2, 2));
    if (!first || !last || *first < 36 || *last < *first || *last - *first > 5) continue;
    const std::string_view code = line.substr(at + 4, 3);
    if (code == "LAD")
      result.latitude_first = static_cast<size_t>(*first), result.latitude_last = static_cast<size_t>(*last);
    if (code == "LOD")
      result.longitude_first = static_cast<size_t>(*first), result.longitude_last = static_cast<size_t>(*last);
  }
  return result;
}

// Digits that continue thousandths of a minute.
double furtherMinutes(std::string_view line, size_t first, size_t last) {
  if (first == 0 || last > line.size()) return 0;
  const auto value = digits(line.substr(first - 1, last - first + 1));
  return value ? *value * std::pow(10.0, -3.0 - static_cast<double>(last - first + 1)) : 0;
}

std::optional<double> degrees(std::string_view whole, std::string_view thousandths, double further_minutes) {
  const auto d = digits(whole), m = digits(thousandths);
  if (!d || !m || *m >= 60'000) return std::nullopt;
  return *d + (*m / 1000.0 + further_minutes) / 60.0;
}

// B HHMMSS DDMMmmmN DDDMMmmmE V PPPPP GGGGG
std::optional<BRecord> parseFix(std::string_view line, const Extensions& extensions) {
  if (line.size() < 35) return std::nullopt;
  const auto h = digits(line.substr(1, 2)), m = digits(line.substr(3, 2)), s = digits(line.substr(5, 2));
  const auto latitude = degrees(line.substr(7, 2), line.substr(9, 5),
                                furtherMinutes(line, extensions.latitude_first, extensions.latitude_last));
  const auto longitude = degrees(line.substr(15, 3), line.substr(18, 5),
                                 furtherMinutes(line, extensions.longitude_first, extensions.longitude_last));
  const auto pressure = number(line.substr(25, 5)), gps = number(line.substr(30, 5));
  const char ns = line[14], ew = line[23], validity = line[24];
  if (!h || !m || !s || !latitude || !longitude || !pressure || !gps) return std::nullopt;
  if (*h > 23 || *m > 59 || *s > 59 || (ns != 'N' && ns != 'S') || (ew != 'E' && ew != 'W')) return std::nullopt;
  if (validity != 'A' && validity != 'V') return std::nullopt;
  return BRecord{.day_s = *h * 3600.0 + *m * 60.0 + *s,
                 .latitude_deg = ns == 'N' ? *latitude : -*latitude,
                 .longitude_deg = ew == 'E' ? *longitude : -*longitude,
                 .pressure_height_m = static_cast<double>(*pressure),
                 .gps_height_m = static_cast<double>(*gps),
                 .is_three_dimensional = validity == 'A'};
}

// Satellite heights if any fix has one; recorders without them write zero.
void addFixes(std::vector<BRecord> records, TrackBuilder& builder) {
  // Invalid fixes have a height of the air's pressure at most, and the last known position or none. Recorders that mark
  // all of them have no satellites' heights, but positions.
  const bool has_valid = std::ranges::count_if(records, &BRecord::is_three_dimensional) >= 2;
  if (has_valid) {
    for (const BRecord& r : records)
      if (!r.is_three_dimensional) builder.skip(r.line, "marked as invalid (V)");
    std::erase_if(records, [](const BRecord& r) { return !r.is_three_dimensional; });
  } else if (!records.empty()) {
    builder.note("all fixes are marked as invalid (V); flown nevertheless");
  }
  bool has_gps = false, has_pressure = false;
  for (const BRecord& r : records) {
    has_gps = has_gps || (r.is_three_dimensional && r.gps_height_m != 0);
    has_pressure = has_pressure || r.pressure_height_m != 0;
  }
  if (!has_gps && has_pressure) builder.note("no satellite heights; pressure heights used");
  double days_s = 0, last_day_s = records.empty() ? 0 : records.front().day_s;
  for (const BRecord& r : records) {
    double before_midnight_s = 0;
    if (r.day_s < last_day_s - kDay_s / 2) {  // midnight; smaller steps back are fixes out of order
      days_s += kDay_s;
      last_day_s = r.day_s;
    } else if (days_s > 0 && r.day_s > last_day_s + kDay_s / 2) {  // a straggler from before midnight
      before_midnight_s = kDay_s;
    } else {
      last_day_s = std::max(last_day_s, r.day_s);
    }
    RawFix fix{days_s - before_midnight_s + r.day_s, r.latitude_deg, r.longitude_deg, std::nullopt};
    if (has_gps) {
      if (r.is_three_dimensional) fix.height_m = r.gps_height_m;
    } else if (has_pressure) {
      fix.height_m = r.pressure_height_m;
    }
    builder.add(r.line, fix);
  }
}

}  // namespace

Result<Track> parseIgc(std::string_view text, const std::string& name) {
  TrackBuilder builder(name);
  Extensions extensions;
  std::vector<BRecord> records;
  Lines lines(text);
  for (std::string_view line; records.size() < Track::kMaxFixes && lines.next(line);) {
    while (!line.empty() && line.back() == ' ') line.remove_suffix(1);
    if (line.empty()) continue;
    if (line[0] == 'I') extensions = parseExtensions(line);
    if (line[0] != 'B') continue;
    auto record = parseFix(line, extensions);
    if (!record) {
      builder.skip(lines.number(), "not a fix (B record)");
      continue;
    }
    record->line = lines.number();
    records.push_back(*record);
  }
  if (text.find("ALTGPS:WGS84 ELLIPSOID") != std::string_view::npos || text.find("HFALG:ELL") != std::string_view::npos)
    builder.note("heights are above the ellipsoid; terrain is usually above the geoid (up to 100 m apart)");
  addFixes(std::move(records), builder);
  return std::move(builder).finish("an IGC");
}

}  // namespace foreland::client
