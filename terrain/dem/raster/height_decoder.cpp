#include "terrain/dem/raster/height_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "terrain/elevation_source.h"

namespace foreland::terrain {

namespace {

constexpr double kRareGap_m = 2000;   // from all heights: a rare sentinel is a void if it lies farther away than this,
constexpr double kCommonGap_m = 500;  // a frequent one if it lies farther away than this
constexpr double kTrace = 0.001;
constexpr uint64_t kSurveyAll = uint64_t{1} << 25;  // samples
constexpr uint32_t kBandRows = 64, kBands = 16;

int sentinelIndex(float raw) {
  const auto at = std::find(HeightDecoder::kSentinels.begin(), HeightDecoder::kSentinels.end(), raw);
  return at == HeightDecoder::kSentinels.end() ? -1 : static_cast<int>(at - HeightDecoder::kSentinels.begin());
}

bool isPlausible(float metres) {
  return metres >= HeightDecoder::kLowestPlausible_m && metres <= HeightDecoder::kHighestPlausible_m;
}

Status surveyRows(uint32_t first, uint32_t count, uint32_t width, const ReadRaw& read, HeightDecoder& decoder) {
  std::vector<float> rows(size_t{width} * std::min(count, kBandRows));
  for (uint32_t done = 0; done < count; done += kBandRows) {
    const uint32_t n = std::min(kBandRows, count - done);
    const std::span<float> part(rows.data(), size_t{width} * n);
    if (Status s = read(first + done, n, part); !s.ok()) return s;
    decoder.observe(part);
  }
  return {};
}

}  // namespace

HeightDecoder::HeightDecoder(std::optional<double> nodata, Units units) : units_(units) {
  if (nodata) nodata_ = static_cast<float>(*nodata);
}

bool HeightDecoder::isTaggedVoid(float raw) const { return !std::isfinite(raw) || (nodata_ && raw == *nodata_); }

void HeightDecoder::observe(std::span<const float> raw) {
  survey_.samples += raw.size();
  for (const float value : raw) {
    if (isTaggedVoid(value)) {
      ++survey_.voids;
      continue;
    }
    if (const int sentinel = sentinelIndex(value); sentinel >= 0) {
      ++sentinel_count_[static_cast<size_t>(sentinel)];
      continue;
    }
    const float height = metres(value);
    if (!isPlausible(height)) {
      ++survey_.voids;
      ++implausible_;
      implausible_example_ = value;
      continue;
    }
    survey_.lowest = has_height_ ? std::min(survey_.lowest, height) : height;
    survey_.highest = has_height_ ? std::max(survey_.highest, height) : height;
    has_height_ = true;
  }
}

void HeightDecoder::classifySentinels() {
  const HeightSurvey others = survey_;
  const bool any_other = has_height_;
  for (size_t i = 0; i < kSentinels.size(); ++i) {
    const float height = metres(kSentinels[i]);
    const double gap = std::max({0.0, double{others.lowest} - height, double{height} - others.highest});
    const bool common = static_cast<double>(sentinel_count_[i]) > kTrace * static_cast<double>(survey_.samples);
    sentinel_is_void_[i] = !any_other || !isPlausible(height) || gap >= (common ? kCommonGap_m : kRareGap_m);
    if (sentinel_count_[i] == 0) continue;
    if (sentinel_is_void_[i]) {
      survey_.voids += sentinel_count_[i];
    } else {
      survey_.lowest = std::min(survey_.lowest, height);
      survey_.highest = std::max(survey_.highest, height);
    }
  }
}

void HeightDecoder::decode(std::span<float> values) const {
  for (float& value : values) {
    if (isTaggedVoid(value)) {
      value = kVoid;
      continue;
    }
    if (const int sentinel = sentinelIndex(value); sentinel >= 0 && sentinel_is_void_[static_cast<size_t>(sentinel)]) {
      value = kVoid;
      continue;
    }
    value = metres(value);
    if (!isPlausible(value)) value = kVoid;
  }
}

std::vector<std::string> HeightDecoder::notes() const {
  // A percentage, because of a large raster only some samples were observed.
  const auto percent = [&](uint64_t count) {
    return 100.0 * static_cast<double>(count) / static_cast<double>(survey_.samples);
  };
  std::vector<std::string> notes;
  for (size_t i = 0; i < kSentinels.size(); ++i)
    if (sentinel_count_[i] > 0 && sentinel_is_void_[i])
      notes.push_back(fmt::format(
          "{:.3g} % of its samples are {:g}, a value that it does not tag as nodata; they are taken as voids "
          "(--nodata names another value)",
          percent(sentinel_count_[i]), kSentinels[i]));
  if (implausible_ > 0)
    notes.push_back(
        fmt::format("{:.3g} % of its samples, such as {:g}, lie outside {:g} to {:g} m; they are taken as voids",
                    percent(implausible_), implausible_example_, kLowestPlausible_m, kHighestPlausible_m));
  return notes;
}

Status surveyHeights(uint32_t width, uint32_t height, const ReadRaw& read, HeightDecoder& decoder) {
  const HeightDecoder fresh = decoder;
  if (uint64_t{width} * height > kSurveyAll && height > kBands * kBandRows) {
    for (uint32_t band = 0; band < kBands; ++band) {
      const auto first = static_cast<uint32_t>(uint64_t{band} * (height - kBandRows) / (kBands - 1));
      if (Status s = surveyRows(first, kBandRows, width, read, decoder); !s.ok()) return s;
    }
    decoder.classifySentinels();
    if (decoder.survey().voids < decoder.survey().samples) return {};
    decoder = fresh;
  }
  if (Status s = surveyRows(0, height, width, read, decoder); !s.ok()) return s;
  decoder.classifySentinels();
  return {};
}

}  // namespace foreland::terrain
