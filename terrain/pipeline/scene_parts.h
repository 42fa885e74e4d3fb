// What builders of whole and of sparse scenes share. Pure; any thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "terrain/elevation_source.h"
#include "terrain/epochs/read_epoch.h"
#include "terrain/imagery/ground_bounds.h"
#include "terrain/imagery/imagery.h"
#include "terrain/picture_source.h"
#include "terrain/pipeline/build.h"
#include "terrain/store/bilinear.h"
#include "terrain/store/scene.h"
#include "terrain/store/scene_writer.h"
#include "terrain/store/tables/datum_section.h"

namespace foreland::terrain {

inline Error stopped() { return {ErrorCode::kIo, "stopped before the scene was complete; nothing was written"}; }

inline Error onlyVoids(const std::string& title) {
  return {ErrorCode::kMalformed, title + ": holds no data, only voids; check the file and --nodata"};
}

inline Error nothingToBlend() { return {ErrorCode::kInvalidArgument, "there are no epochs to blend"}; }

inline Error changedWhileRead(const std::string& title) {
  return {ErrorCode::kIo, title + ": changed while it was read; build again"};
}

inline proto::LatticeWindow wholeOf(const ElevationInfo& info) { return {0, 0, info.width, info.height}; }

// The epochs that are asked for, with nothing in their windows.
template <class Epoch>
Result<proto::Epochs> datesOf(const std::vector<Epoch>& epochs, proto::EpochBlend blend,
                              const proto::GridShape& shape) {
  std::vector<proto::Epoch> dates;
  for (const Epoch& epoch : epochs) dates.push_back({epoch.time, {}});
  return proto::Epochs::create(shape, std::move(dates), blend);
}

// A source with the first of some epochs laid over it, if there are any, by checkEpochs(). It must outlive what is
// returned.
inline std::shared_ptr<ElevationSource> atFirstEpoch(ElevationSource& source, const std::vector<EpochRequest>& epochs) {
  if (epochs.empty()) return {std::shared_ptr<void>(), &source};
  return std::make_shared<FirstEpoch>(source, epochs.front(), windowOf(epochs.front(), source.info()).value());
}

// Padding not counted.
inline uint64_t nodeCount(const proto::GridTopology& grid) {
  const proto::GridShape& s = grid.shape();
  return (grid.maxX() + 1ull) * (grid.maxY() + 1ull) - (s.roots_x + 1ull) * (s.roots_y + 1ull) -
         static_cast<uint64_t>(s.roots_x) * s.roots_y;
}

inline Result<proto::GridTopology> gridFor(const ElevationInfo& info) {
  if (info.width < 2 || info.height < 2 || info.width > proto::GridTopology::kMaxSamples ||
      info.height > proto::GridTopology::kMaxSamples)
    return Error{ErrorCode::kUnsupported, info.title + ": " + std::to_string(info.width) + " x " +
                                              std::to_string(info.height) +
                                              " samples; a scene needs at least 2 and at most 2^20 a side"};
  return proto::GridTopology::create(proto::GridTopology::shapeFor(info.width, info.height));
}

inline std::string quantumNote(double quantum_m) {
  return "all heights are multiples of " +
         std::string(quantum_m == 1     ? "1"
                     : quantum_m == 0.5 ? "0.5"
                                        : "0.25") +
         " m, and are kept in steps of it";
}

// Corners and centres of the roots, of which heightAt(x, y) knows the heights.
template <class HeightAt>
void fillBase(const proto::GridShape& shape, const HeightAt& heightAt, SceneWriter& writer) {
  const uint32_t size = 1u << shape.root_log2, half = size / 2;
  auto corner = writer.corners().begin();
  for (uint32_t y = 0; y <= shape.roots_y; ++y)
    for (uint32_t x = 0; x <= shape.roots_x; ++x) *corner++ = heightAt(x * size, y * size);
  auto centre = writer.centres().begin();
  for (uint32_t y = 0; y < shape.roots_y; ++y)
    for (uint32_t x = 0; x < shape.roots_x; ++x) *centre++ = heightAt(x * size + half, y * size + half);
}

// Reports a stage's progress.
inline KeepGoing stage(const Progress& progress, std::string_view name) {
  progress.report(name, 0);
  return [&progress, name](double fraction) {
    progress.report(name, fraction);
    return progress.keepGoing();
  };
}

// What tells objects the ground's height in metres at a lattice position, nothing outside the data: bilinear between
// the samples, of which at(x, y) knows the quanta.
template <class At>
auto groundOf(const ElevationInfo& info, const proto::Frame& frame, const At& at) {
  return [width = info.width, height = info.height, quantum_m = frame.height_quantum_m, at](
             double x, double y) -> std::optional<double> {
    if (!(x >= 0 && y >= 0 && x <= width - 1.0 && y <= height - 1.0)) return std::nullopt;
    return bilinear(width, height, x, y, at) * quantum_m;
  };
}

// What tells tiles of pictures the bounds of the ground below them.
inline BoundsOf boundsOver(HeightsByWindow heights, const proto::Frame& frame) {
  return [ground = std::make_shared<const GroundBounds>(std::move(heights), frame)](
             const proto::LatticeBox& box, std::vector<glm::dvec3>& scratch) { return ground->over(box, scratch); };
}

// The same of ground that changes in time, of which the lowest and the highest heights are known. Normals of the ground
// at other times are not, so the cone holds all.
inline BoundsOf boundsBetween(HeightsByWindow lowest, HeightsByWindow highest, const proto::Frame& frame) {
  return [lowest = boundsOver(std::move(lowest), frame), highest = boundsOver(std::move(highest), frame)](
             const proto::LatticeBox& box, std::vector<glm::dvec3>& scratch) -> Result<proto::TileBounds> {
    const auto low = lowest(box, scratch), high = highest(box, scratch);
    if (!low || !high) return low ? high : low;
    return proto::TileBounds{low->lowest_m, high->highest_m, {0, 0, 0}, 255};
  };
}

// Samples that stayed where they were differ by rounding alone; that comes to what others differ by.
inline SceneDatum datumOf(const proto::VerticalDatum& vertical, const std::vector<ElevationInput>& inputs,
                          double height_quantum_m) {
  SceneDatum datum{vertical, {}};
  for (const ElevationInput& input : inputs)
    datum.inputs.push_back({.name = input.name,
                            .vertical = input.vertical,
                            .window = input.window,
                            .may_have_voids = input.may_have_voids,
                            .residual_m = (input.is_on_lattice ? 0 : input.residual_m) + 0.5 * height_quantum_m,
                            .feather_m = input.feather_m});
  return datum;
}

inline void describePicture(const std::vector<std::string>& notes, const ImageryReport& report, SceneOrigin& origin) {
  for (const std::string& note : notes) origin.notes.push_back(note);
  if (report.covered < 1)
    origin.notes.push_back("pictures cover " + std::to_string(static_cast<int>(report.covered * 100)) +
                           " % of the scene; the rest fades from what is nearest to it");
}

inline Result<ImageryReport> addPicture(PictureSource& picture, const BoundsOf& boundsOf, const ImageryOptions& options,
                                        const Progress& progress, SceneOrigin& origin, TileSection& section) {
  auto report = addImagery(picture, boundsOf, options, stage(progress, "imagery"), section);
  if (!report) return report;
  if (!report->is_complete) return stopped();
  describePicture(picture.info().notes, *report, origin);
  return report;
}

}  // namespace foreland::terrain
