#include "terrain/epochs/read_epoch.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <optional>

namespace foreland::terrain {

namespace {

// How far samples may lie from the scene's, in sample spacings.
constexpr double kMaxOff = 0.01;
constexpr uint32_t kSamplesAtOnce = 1u << 20;

bool isNear(double a, double b, double scale) { return std::fabs(a - b) <= 1e-6 * scale; }
bool isNear(const glm::dvec2& a, const glm::dvec2& b) { return glm::distance(a, b) <= 1e-6 * glm::length(b); }

// Where lattice (0, 0) of `frame` lies on the lattice of `base`; nothing if their spacings differ.
std::optional<glm::dvec2> originOn(const proto::Frame& base, const proto::Frame& frame) {
  if (frame.kind != base.kind) return std::nullopt;
  if (base.kind == proto::FrameKind::kPlanar) {
    if (!isNear(frame.axis_x_m, base.axis_x_m) || !isNear(frame.axis_y_m, base.axis_y_m)) return std::nullopt;
    const auto corner = [](const proto::Frame& f) {
      return f.map_origin_m - f.anchor.x * f.axis_x_m - f.anchor.y * f.axis_y_m;
    };
    return glm::inverse(glm::dmat2(base.axis_x_m, base.axis_y_m)) * (corner(frame) - corner(base));
  }
  if (!isNear(frame.latitude_step_rad, base.latitude_step_rad, base.latitude_step_rad) ||
      !isNear(frame.longitude_step_rad, base.longitude_step_rad, base.longitude_step_rad))
    return std::nullopt;
  return glm::dvec2((frame.longitude0_rad - base.longitude0_rad) / base.longitude_step_rad,
                    (frame.latitude0_rad - base.latitude0_rad) / base.latitude_step_rad);
}

Result<proto::LatticeWindow> windowOn(const ElevationInfo& epoch, const ElevationInfo& base) {
  const auto refused = [&](const std::string& why) {
    return Error{ErrorCode::kInvalidArgument, epoch.title + ": " + why};
  };
  if (!epoch.crs_wkt.empty() && !base.crs_wkt.empty() && epoch.crs_wkt != base.crs_wkt)
    return refused("its reference system is not that of " + base.title + "; warp it with gdalwarp -t_srs");
  if (!epoch.vertical.name.empty() && !base.vertical.name.empty() && epoch.vertical.name != base.vertical.name)
    return refused("its heights are above " + epoch.vertical.name + ", those of " + base.title + " above " +
                   base.vertical.name + "; say both by --vertical");
  const auto origin = originOn(base.frame, epoch.frame);
  if (!origin)
    return refused("its samples are spaced otherwise than those of " + base.title + "; resample it onto the same grid");
  const glm::dvec2 whole(std::round(origin->x), std::round(origin->y));
  if (glm::distance(whole, *origin) > kMaxOff)
    return refused("its samples lie between those of " + base.title + "; resample it onto the same grid");
  if (whole.x < 0 || whole.y < 0 || whole.x + epoch.width > base.width || whole.y + epoch.height > base.height)
    return refused("it reaches beyond " + base.title + "; cut it to the scene's extent");
  return proto::LatticeWindow{static_cast<uint32_t>(whole.x), static_cast<uint32_t>(whole.y), epoch.width,
                              epoch.height};
}

}  // namespace

Status checkDates(const std::vector<EpochRequest>& epochs) {
  for (size_t i = 1; i < epochs.size(); ++i) {
    const EpochRequest &before = epochs[i - 1], &epoch = epochs[i];
    if (epoch.time == before.time)
      return Error{ErrorCode::kInvalidArgument, "two epochs are of " + epoch.date + "; name one file for each date"};
    if (epoch.time < before.time)
      return Error{ErrorCode::kInvalidArgument,
                   "the epoch of " + epoch.date + " comes after that of " + before.date + "; name them in order"};
  }
  return {};
}

bool isOnLatticeOf(const ElevationInfo& epoch, const ElevationInfo& base) {
  if (!epoch.crs_wkt.empty() && !base.crs_wkt.empty() && epoch.crs_wkt != base.crs_wkt) return false;
  const auto origin = originOn(base.frame, epoch.frame);
  return origin && glm::distance(glm::dvec2(std::round(origin->x), std::round(origin->y)), *origin) <= kMaxOff;
}

Result<proto::LatticeWindow> windowOf(const EpochRequest& epoch, const ElevationInfo& base) {
  if (!epoch.source) return proto::LatticeWindow{};
  const auto window = windowOn(epoch.source->info(), base);
  if (!window) return Error{window.error().code, "epoch " + epoch.date + ": " + window.error().message};
  return window;
}

Status checkEpochs(const std::vector<EpochRequest>& epochs, const ElevationInfo& base) {
  if (Status s = checkDates(epochs); !s.ok()) return s;
  for (const EpochRequest& epoch : epochs)
    if (const auto window = windowOf(epoch, base); !window) return window.error();
  return {};
}

Result<EpochSamples> readEpoch(const EpochRequest& epoch, const ElevationInfo& base, const proto::LatticeWindow& part) {
  const auto window = windowOf(epoch, base);
  if (!window) return window.error();
  EpochSamples samples{epoch.time, epoch.date, proto::LatticeWindow::common(*window, part), {}};
  const proto::LatticeWindow& w = samples.window;
  if (w.isEmpty()) return samples;
  samples.metres.resize(static_cast<size_t>(w.width) * w.height);
  const bool is_all_of_rows = w.width == window->width;
  const auto step = is_all_of_rows ? w.height : std::max(kSamplesAtOnce / window->width, 1u);
  std::vector<float> rows;
  for (uint32_t done = 0; done < w.height; done += step) {
    const uint32_t count = std::min(step, w.height - done), first = w.y - window->y + done;
    if (is_all_of_rows) {
      if (Status s = epoch.source->readRows(first, count, samples.metres); !s.ok()) return s.error();
      continue;
    }
    rows.resize(static_cast<size_t>(count) * window->width);
    if (Status s = epoch.source->readRows(first, count, rows); !s.ok()) return s.error();
    for (size_t i = 0; i < count; ++i)
      std::copy_n(rows.begin() + static_cast<ptrdiff_t>(i * window->width + (w.x - window->x)), w.width,
                  samples.metres.begin() + static_cast<ptrdiff_t>((done + i) * w.width));
  }
  return samples;
}

Error heightDoesNotFit(const std::string& date, float metres) {
  return {ErrorCode::kLimit, "epoch " + date + ": a height of " + std::to_string(metres) +
                                 " m does not fit the scene's steps; use a larger --vertical-step"};
}

Status FirstEpoch::readRows(uint32_t first, uint32_t count, std::span<float> out) {
  if (Status s = base_.readRows(first, count, out); !s.ok()) return s;
  const uint32_t width = info().width;
  const proto::LatticeWindow w = proto::LatticeWindow::common(window_, {0, first, width, count});
  if (w.isEmpty()) return {};
  std::vector<float> rows(static_cast<size_t>(w.width) * w.height);
  if (Status s = epoch_->readRows(w.y - window_.y, w.height, rows); !s.ok()) return s;
  for (size_t y = 0; y < w.height; ++y)
    for (size_t x = 0; x < w.width; ++x)
      if (const float height = rows[y * w.width + x]; !std::isnan(height))
        out[(w.y - first + y) * width + w.x + x] = height;
  return {};
}

}  // namespace foreland::terrain
