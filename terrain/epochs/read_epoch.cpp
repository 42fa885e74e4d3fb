#include "terrain/epochs/read_epoch.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <optional>

namespace foreland::terrain {

namespace {

// How far samples may lie from the scene's, in sample spacings.
constexpr double kMaxOff = 0.01;

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

Result<proto::LatticeWindow> windowOf(const ElevationInfo& epoch, const ElevationInfo& base) {
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

Result<EpochSamples> readEpoch(const EpochRequest& epoch, const ElevationInfo& base) {
  const ElevationInfo& info = epoch.source->info();
  const auto window = windowOf(info, base);
  if (!window) return Error{window.error().code, "epoch " + epoch.date + ": " + window.error().message};
  EpochSamples samples{epoch.time, epoch.date, *window, {}};
  samples.metres.resize(static_cast<size_t>(info.width) * info.height);
  if (Status s = epoch.source->readRows(0, info.height, samples.metres); !s.ok()) return s.error();
  return samples;
}

}  // namespace foreland::terrain
