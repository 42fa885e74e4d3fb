// The poses of `foreland remesh --pose`: models of one connectivity at several dates, made surfaces of one topology.
// Main thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/remesh/remesh_report.h"
#include "base/result.h"
#include "base/time.h"
#include "terrain/model/model.h"
#include "terrain/remesh/remesh.h"
#include "terrain/surface/surface.h"

namespace foreland::apps {

struct Pose {
  Time time;
  std::string date;
  terrain::Model model;
  std::vector<glm::dvec3> positions;  // of the original's vertices
};

// How the models of one surface are read.
struct ModelReading {
  std::optional<terrain::UpAxis> up;           // which axis points up, whatever the format says
  std::vector<std::filesystem::path> allowed;  // further folders of files that a model names
};
[[nodiscard]] Result<terrain::Model> readUpright(const std::filesystem::path& file, const ModelReading& reading);

// Of texts YYYY-MM-DD=FILE; the models are moved as `model` was. An Error names the text that is none, out of order, or
// whose file is no pose of `model`.
[[nodiscard]] Result<std::vector<Pose>> readPoses(const std::vector<std::string>& texts, const ModelReading& reading,
                                                  const glm::dvec3& origin, const terrain::Model& model,
                                                  const terrain::Original& original);

// The surface in its first pose, with the others; and how far each is from its model.
struct PosedSurface {
  terrain::TrueSurface surface;
  std::vector<PoseReport> reports;
};
[[nodiscard]] Result<PosedSurface> makePosed(const std::vector<Pose>& poses, const terrain::Original& original,
                                             const terrain::Remeshed& remeshed, proto::MeshRule rule, double step,
                                             unsigned threads);

}  // namespace foreland::apps
