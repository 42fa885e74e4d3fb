#include "client/screen.h"

#include <utility>

#include "proto/space/undulation_place.h"

namespace foreland::client {

void Screen::enter(proto::Welcome told) {
  welcome = std::move(told);
  transform.emplace(welcome->frame);
  box = boxOf(*welcome, *transform);
}

void Screen::add(const Interval& interval, uint32_t oldest_version) {
  schedule.dropBefore(oldest_version);
  schedule.add(interval);
}

ScreenFrame Screen::frame(Time now, const FrameCamera& seen, proto::Strategy strategy, uint32_t ready,
                          uint32_t coming) {
  camera.add(now, seen.pose);
  const Schedule::Shown shown = schedule.at(now, ready, coming);
  ScreenFrame out{.interval = std::nullopt, .pose = seen.pose, .next_version = schedule.next()};
  if (shown.interval == nullptr) return out;
  const ShownFrame frame = showFrame(shown, camera, seen, strategy);
  out.interval = *shown.interval;
  out.pose = frame.pose;
  out.weight = shown.weight;
  out.shown_time = shown.shown_time;
  const auto& [from, to] = std::pair(shown.interval->from, shown.interval->to);
  out.scene_time_us = static_cast<double>(from.scene_time.us) +
                      static_cast<float>(shown.weight) * static_cast<double>((to.scene_time - from.scene_time).us);
  out.tolerance_px = frame.tolerance_px;
  return out;
}

void Screen::takeGround(ByteSpan update) {
  if (!welcome) return;
  std::optional<proto::TileLayer> relief;
  for (const proto::TileLayer& layer : welcome->tile_layers)
    if (layer.content == proto::TileContent::kRelief) relief = layer;
  ground.take(update, relief);
}

std::optional<glm::dvec3> Screen::groundOn(const Ray& ray) const {
  return rayOnGround(ground.heights(), *transform, box.low, box.high, ray);
}

ScreenPlace Screen::placeAt(const glm::dvec3& point) const {
  ScreenPlace out{mapPositionOf(*transform, point), std::nullopt, std::nullopt, std::nullopt};
  const glm::dvec2 lattice = out.at.lattice;
  out.ground_m = ground.heights().heightAt(lattice);
  if (const auto gradient = ground.heights().gradientAt(lattice))
    out.slope_rad = slopeOf(*transform, {lattice.x, lattice.y, *out.ground_m}, *gradient);
  const proto::UndulationGrid& undulations = welcome->vertical.undulations;
  if (!undulations.isEmpty()) out.undulation_m = undulations.at(proto::undulationPlace(*transform, lattice));
  return out;
}

}  // namespace foreland::client
