#include "oracle/globe/source_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "oracle/globe/cube_faces.h"
#include "oracle/globe/faces_of_mesh.h"
#include "oracle/surface/oracle_eye.h"

namespace foreland::oracle {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kCells = 64;            // along a side of a face
constexpr double kRounding_m = 0.01;  // of floats that residuals and undulations are in

struct PlacedSample {
  glm::dvec3 position;
  glm::dvec2 place;
};

// Samples of a block on one face.
struct Patch {
  uint32_t face = 0;
  double allowed_m = 0;  // that the scene's ground may be off them
  glm::dvec2 low{INFINITY}, high{-INFINITY};
  glm::dvec3 centre{0};
  double radius = 0;
  std::vector<PlacedSample> samples;
};

// A mesh's triangles by cells of the faces that they meet.
class DrawnTriangles {
 public:
  DrawnTriangles(const client::KeyframeMesh& mesh, double weight, const CubeFaces& cube)
      : mesh_(mesh),
        weight_(weight),
        cell_(static_cast<double>(cube.side()) / kCells),
        triangles_(trianglesOnFaces(mesh, cube)),
        cells_(size_t{6} * kCells * kCells) {
    for (uint32_t i = 0; i < triangles_.size(); ++i) {
      const auto& p = triangles_[i].place;
      forEachCell(triangles_[i].face, glm::min(p[0], glm::min(p[1], p[2])), glm::max(p[0], glm::max(p[1], p[2])),
                  [&](std::vector<uint32_t>& cell) { cell.push_back(i); });
    }
  }

  // Where samples are drawn; not numbers where nothing is.
  void find(const Patch& patch, std::vector<glm::dvec3>& out) const {
    out.assign(patch.samples.size(), glm::dvec3(kNone));
    forEachCell(patch.face, patch.low, patch.high, [&](const std::vector<uint32_t>& cell) {
      for (const uint32_t i : cell) findIn(triangles_[i], patch, out);
    });
  }

 private:
  template <class Visit>
  void forEachCell(uint32_t face, glm::dvec2 low, glm::dvec2 high, const Visit& visit) const {
    const auto cell = [&](double v) { return std::clamp(static_cast<int>(v / cell_), 0, kCells - 1); };
    for (int y = cell(low.y); y <= cell(high.y); ++y)
      for (int x = cell(low.x); x <= cell(high.x); ++x)
        visit(cells_[(size_t{face} * kCells + static_cast<size_t>(y)) * kCells + static_cast<size_t>(x)]);
  }

  void findIn(const FaceTriangle& t, const Patch& patch, std::vector<glm::dvec3>& out) const {
    const auto& [a, b, c] = t.place;
    const glm::dvec2 low = glm::min(a, glm::min(b, c)), high = glm::max(a, glm::max(b, c));
    if (low.x > patch.high.x || low.y > patch.high.y || high.x < patch.low.x || high.y < patch.low.y) return;
    const auto area = [](glm::dvec2 u, glm::dvec2 v) { return u.x * v.y - u.y * v.x; };
    const double all = area(b - a, c - a);
    std::array<glm::dvec3, 3> corner;
    for (size_t k = 0; k < 3; ++k) corner[k] = mesh_.origin + glm::dvec3(mesh_.at(t.vertex[k], weight_));
    for (size_t i = 0; i < patch.samples.size(); ++i) {
      const glm::dvec2 p = patch.samples[i].place - a;
      const double at_b = area(p, c - a) / all, at_c = area(b - a, p) / all, at_a = 1 - at_b - at_c;
      constexpr double kOnEdge = -1e-9;
      if (at_a >= kOnEdge && at_b >= kOnEdge && at_c >= kOnEdge)
        out[i] = at_a * corner[0] + at_b * corner[1] + at_c * corner[2];
    }
  }

  const client::KeyframeMesh& mesh_;
  double weight_, cell_;
  std::vector<FaceTriangle> triangles_;
  mutable std::vector<std::vector<uint32_t>> cells_;
};

}  // namespace

struct SourceOracle::Ground {
  CubeFaces cube;
  terrain::Ellipsoid ellipsoid, lowest;
  std::vector<Patch> patches;

  Ground(const terrain::Scene& scene, const std::vector<SourceBlock>& blocks)
      : cube(scene.grid().shape().root_log2),
        ellipsoid{scene.frame().semi_major_m, scene.frame().flattening},
        lowest(lowestEllipsoid(scene)) {
    for (const SourceBlock& block : blocks) add(scene, block);
  }

 private:
  void add(const terrain::Scene& scene, const SourceBlock& block) {
    std::array<Patch, 6> of_face;
    for (const proto::Geodetic& at : block.samples) {
      const auto [face, place] =
          cube.placeOf({std::cos(at.latitude_rad) * std::cos(at.longitude_rad),
                        std::cos(at.latitude_rad) * std::sin(at.longitude_rad), std::sin(at.latitude_rad)});
      Patch& patch = of_face[face];
      patch.face = face;
      patch.samples.push_back({terrain::referencePosition(ellipsoid, at), place});
      patch.low = glm::min(patch.low, place), patch.high = glm::max(patch.high, place);
      patch.allowed_m =
          std::max(patch.allowed_m, scene.inputs()[block.input].residual_m + kRounding_m + bendAt(scene, face, place));
    }
    for (Patch& patch : of_face) {
      if (patch.samples.empty()) continue;
      for (const PlacedSample& s : patch.samples) patch.centre += s.position;
      patch.centre /= static_cast<double>(patch.samples.size());
      for (const PlacedSample& s : patch.samples)
        patch.radius = std::max(patch.radius, glm::distance(patch.centre, s.position));
      patches.push_back(std::move(patch));
    }
  }

  // How far a point of a triangle may lie aside of the place that it has on the cube: residuals are heights above where
  // it lies. By second derivatives of less than 1.1 radii for half a face's side (decision 0062), and by normals that
  // are not parallel where heights differ.
  static double bendAt(const terrain::Scene& scene, uint32_t face, glm::dvec2 place) {
    const double edge = longestEdgeAt(scene, face, place), half = 0.5 * scene.frame().face_steps;
    const double range_m = (scene.heightRange().highest - scene.heightRange().lowest) * scene.frame().height_quantum_m;
    const double angle = edge * longestStep(scene.frame()) / scene.frame().semi_major_m;
    return 1.1 * scene.frame().semi_major_m * (edge / half) * (edge / half) / 8 + angle * range_m;
  }
};

SourceOracle::SourceOracle(const terrain::Scene& scene, const std::vector<SourceBlock>& blocks)
    : ground_(std::make_shared<const Ground>(scene, blocks)) {}

SourceDeviation SourceOracle::error(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose,
                                    const proto::Lens& lens, const Sight& sight) const {
  const OracleEye eye(pose, lens);
  const DrawnTriangles triangles(mesh, weight, ground_->cube);
  const auto isHidden = [&](const glm::dvec3& point) {
    return isBehind(ground_->lowest, eye.at, point) || (sight.is_seen && !sight.is_seen(point, eye.at));
  };
  SourceDeviation out;
  std::vector<glm::dvec3> drawn;
  for (const Patch& patch : ground_->patches) {
    if (!eye.maySee(patch.centre, patch.radius)) continue;
    const auto isSeen = [&](const PlacedSample& s) {
      // Nearer to the eye what the residual looks like has no bound.
      return eye.depth(s.position) > std::max(Oracle::kDefaultNear_m, 2 * patch.allowed_m) &&
             eye.sees(eye.project(s.position));
    };
    if (std::ranges::none_of(patch.samples, isSeen)) continue;
    triangles.find(patch, drawn);
    for (size_t i = 0; i < drawn.size(); ++i) {
      const glm::dvec3& at = patch.samples[i].position;
      if (!isSeen(patch.samples[i])) continue;
      if (std::isnan(drawn[i].x)) {
        out.uncovered += !isHidden(at);
        continue;
      }
      const glm::dvec2 pixel = eye.project(at);
      // A drawn point behind the eye counts as very near, hence as very wrong.
      const double depth = std::max(0.01 * Oracle::kDefaultNear_m, eye.depth(drawn[i]));
      const glm::dvec2 off(glm::dot(drawn[i] - eye.at, eye.right), glm::dot(drawn[i] - eye.at, eye.up));
      const double px = glm::distance(off * (eye.focal / depth), pixel);
      // A ball of that radius around the sample, on the screen.
      const double allowed_px =
          patch.allowed_m * std::hypot(eye.focal, glm::length(pixel)) / (eye.depth(at) - patch.allowed_m);
      if ((px > out.max_px || px - allowed_px > sight.limit_px) && isHidden(at)) continue;
      ++out.samples;
      out.max_px = std::max(out.max_px, px);
      out.excess_px = std::max(out.excess_px, px - allowed_px);
    }
  }
  return out;
}

}  // namespace foreland::oracle
