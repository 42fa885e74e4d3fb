#include "lab/drape/drape_judge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>

#include "proto/space/frame.h"

namespace foreland::lab {

namespace {

constexpr uint32_t kBlockEach_px = 240, kRowEach_px = 180;  // a block of so many pixels: 8 x 6 of 1920 x 1080
constexpr uint32_t kBlockSide = 24;                         // pixels
constexpr uint32_t kAcross = 4;                             // samples of a pixel, and as many down
constexpr uint32_t kSamples = kAcross * kAcross;
constexpr uint32_t kWindow = 8;  // pixels a side, for SSIM
constexpr uint32_t kComparedEach_px = 6;
constexpr double kSameLevel = 0.004;  // less than what 8 bits of a fade tell

struct Moments {
  double sum = 0, squares = 0;
};

double ssimOf(const std::vector<float>& a, const std::vector<float>& b, uint32_t left, uint32_t top) {
  Moments of_a, of_b;
  double product = 0;
  constexpr double n = kWindow * kWindow;
  for (uint32_t y = top; y < top + kWindow; ++y)
    for (uint32_t x = left; x < left + kWindow; ++x) {
      const double p = a[y * kBlockSide + x], q = b[y * kBlockSide + x];
      of_a.sum += p, of_a.squares += p * p, of_b.sum += q, of_b.squares += q * q, product += p * q;
    }
  const double ma = of_a.sum / n, mb = of_b.sum / n;
  const double va = of_a.squares / n - ma * ma, vb = of_b.squares / n - mb * mb, cov = product / n - ma * mb;
  constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
  return (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
}

// The finest drawn tile at a point that is no finer than `level`; the number of levels if there is none.
struct Found {
  uint32_t level;
  float fade;
};
Found find(const LayerImage& image, const sim::DrawnTiles& drawn, const glm::dvec2& lattice, uint32_t level) {
  const proto::TileLayer& layer = image.layer();
  for (; level < layer.levels(); ++level) {
    const glm::dvec2 at = (lattice - layer.origin) / (layer.texelAt(level) * proto::kTilePayload);
    const proto::TileId tile{image.index(), static_cast<uint8_t>(level), static_cast<uint32_t>(std::max(0.0, at.x)),
                             static_cast<uint32_t>(std::max(0.0, at.y))};
    if (const auto found = drawn.find(tile.key()); found != drawn.end()) return {level, found->second};
  }
  return {level, 0};
}

// Of a sample's part of a pixel that covers so much ground.
double lodOf(const LayerImage& image, float pixel) {
  return std::log2(std::max(1e-9, pixel / image.layer().texel / kAcross));
}

// Nothing if there is no tile.
std::optional<double> levelShown(const LayerImage& image, const sim::DrawnTiles& drawn, const glm::dvec2& lattice,
                                 double lod) {
  const Found tile = find(image, drawn, lattice, static_cast<uint32_t>(std::max(0.0, std::floor(lod))));
  if (tile.level >= image.layer().levels()) return std::nullopt;
  return std::max(lod, static_cast<double>(tile.level) + tile.fade);
}

// How many sample intervals a pixel covers on the ground, as the root of its area there over that of a sample's cell.
float pixelOnGround(const proto::FrameTransform& frame, const terrain::RayHit& hit, const glm::dvec3& along,
                    const glm::dvec3& forward, double focal_px) {
  const double off_axis = glm::dot(along, forward);
  const double solid_angle = off_axis * off_axis * off_axis / (focal_px * focal_px);
  const double area_m2 = solid_angle * hit.distance_m * hit.distance_m / std::max(1e-3, -glm::dot(hit.normal, along));
  const auto at = [&](double dx, double dy) {
    return frame.toScene(proto::LatticePosition{hit.parameter.x + dx, hit.parameter.y + dy, hit.height_m});
  };
  const glm::dvec3 cell = glm::cross(at(1, 0) - at(0, 0), at(0, 1) - at(0, 0));
  const double cell_m2 = glm::length(cell) / std::max(0.1, glm::dot(hit.normal, glm::normalize(cell)));
  return static_cast<float>(std::sqrt(area_m2 / cell_m2));
}

}  // namespace

Result<DrapeJudge> DrapeJudge::create(const std::shared_ptr<const terrain::Scene>& scene, const proto::Lens& lens,
                                      std::vector<proto::Pose> poses, double seconds) {
  auto caster = terrain::RayCaster::ofScene(scene);
  if (!caster) return caster.error();
  return DrapeJudge(std::move(*caster), scene, lens, std::move(poses), seconds);
}

DrapeJudge::DrapeJudge(terrain::RayCaster caster, std::shared_ptr<const terrain::Scene> scene, const proto::Lens& lens,
                       std::vector<proto::Pose> poses, double seconds)
    : caster_(std::move(caster)),
      scene_(std::move(scene)),
      lens_(lens),
      poses_(std::move(poses)),
      seconds_(seconds),
      samples_(poses_.size()),
      reference_(poses_.size()) {}

DrapeJudge::Block DrapeJudge::cast(const proto::Pose& pose, uint32_t left, uint32_t top) const {
  const proto::FrameTransform frame(scene_->frame());
  const glm::dvec3 right = pose.right(), up = pose.up(), forward = pose.forward();
  const double focal_px = lens_.focalPx();
  std::vector<terrain::Ray> rays;
  rays.reserve(kBlockSide * kBlockSide * kSamples);
  for (uint32_t pixel = 0; pixel < kBlockSide * kBlockSide; ++pixel)
    for (uint32_t k = 0; k < kSamples; ++k) {
      const double x = left + pixel % kBlockSide + (k % kAcross + 0.5) / kAcross - 0.5 * lens_.width_px,
                   y = 0.5 * lens_.height_px - (top + pixel / kBlockSide + (k / kAcross + 0.5) / kAcross);
      terrain::Ray ray;
      ray.origin = pose.eye;
      ray.direction = glm::normalize(right * x + up * y + forward * focal_px);
      rays.push_back(ray);
    }
  std::vector<std::optional<terrain::RayHit>> hits(rays.size());
  caster_.hit(rays, hits);
  Block block(rays.size());
  for (size_t i = 0; i < rays.size(); ++i)
    if (hits[i] && hits[i]->object == terrain::RayHit::kTerrain)
      block[i] = {hits[i]->parameter, pixelOnGround(frame, *hits[i], rays[i].direction, forward, focal_px)};
  return block;
}

const std::vector<DrapeJudge::Block>& DrapeJudge::samples(size_t frame) {
  std::vector<Block>& blocks = samples_[frame];
  if (!blocks.empty()) return blocks;
  const uint32_t columns = std::max(2u, lens_.width_px / kBlockEach_px),
                 rows = std::max(2u, lens_.height_px / kRowEach_px);
  for (uint32_t row = 0; row < rows; ++row)
    for (uint32_t column = 0; column < columns; ++column)
      blocks.push_back(cast(poses_[frame], (2 * column + 1) * lens_.width_px / (2 * columns) - kBlockSide / 2,
                            (2 * row + 1) * lens_.height_px / (2 * rows) - kBlockSide / 2));
  return blocks;
}

void DrapeJudge::judge(size_t frame, LayerImage& image, const sim::DrawnTiles& drawn, double stated_px) {
  const std::vector<Block>& blocks = samples(frame);
  const bool is_first = reference_[frame].empty();
  reference_[frame].resize(blocks.size());
  uint64_t blurred = 0;
  for (size_t b = 0; b < blocks.size(); ++b) {
    std::vector<float> shown(kBlockSide * kBlockSide), &reference = reference_[frame][b];
    if (is_first) reference.resize(shown.size());
    for (uint32_t pixel = 0; pixel < shown.size(); ++pixel) {
      glm::vec2 truth(0), value(0);
      float hits = 0;
      for (uint32_t k = 0; k < kSamples; ++k) {
        const Sample& s = blocks[b][pixel * kSamples + k];
        if (s.pixel == 0) continue;
        ++hits;
        const double texels = s.pixel / image.layer().texel, lod = lodOf(image, s.pixel);
        const Found tile = find(image, drawn, s.lattice, static_cast<uint32_t>(std::max(0.0, std::floor(lod))));
        if (is_first) truth += image.at(s.lattice, 0u);
        if (tile.level >= image.layer().levels()) {
          ++sum_.not_drawn;
          continue;
        }
        value += image.at(s.lattice, std::max(lod, static_cast<double>(tile.level) + tile.fade));
        if (tile.fade == 0 && !image.hasFiner(s.lattice, tile.level)) continue;
        const auto texel_px = static_cast<float>(std::exp2(tile.level + tile.fade) / texels);
        texels_px_.push_back(texel_px);
        blurred += texel_px > kBlur_px;
        sum_.over_stated += texel_px > 1.01 * stated_px;
      }
      if (is_first) reference[pixel] = hits > 0 ? image.brightness(truth / hits) : 0.0f;
      shown[pixel] = hits > 0 ? image.brightness(value / hits) : 0.0f;
      if (hits == 0) continue;
      squares_ += std::pow(double{shown[pixel]} - reference[pixel], 2);
      ++pixels_;
    }
    for (uint32_t y = 0; y < kBlockSide; y += kWindow)
      for (uint32_t x = 0; x < kBlockSide; x += kWindow, ++windows_) ssim_ += ssimOf(reference, shown, x, y);
  }
  const double samples = static_cast<double>(blocks.size()) * kBlockSide * kBlockSide * kSamples;
  sum_.blur_px_s += seconds_ * static_cast<double>(blurred) / samples * lens_.width_px * lens_.height_px;
}

void DrapeJudge::compare(size_t frame, const LayerImage& image, const sim::DrawnTiles& before,
                         const sim::DrawnTiles& after) {
  const std::vector<Block>& blocks = samples(frame);
  uint64_t jumped = 0, compared = 0;
  for (const Block& block : blocks)
    for (uint32_t y = 0; y < kBlockSide; y += kComparedEach_px)
      for (uint32_t x = 0; x < kBlockSide; x += kComparedEach_px) {
        ++compared;
        const Sample& s = block[(y * kBlockSide + x) * kSamples];
        if (s.pixel == 0) continue;
        const double lod = lodOf(image, s.pixel);
        const std::optional<double> from = levelShown(image, before, s.lattice, lod),
                                    to = levelShown(image, after, s.lattice, lod);
        jumped += from && (!to || std::fabs(*from - *to) > kSameLevel);
      }
  sum_.jumped_pixels += static_cast<double>(jumped) / static_cast<double>(compared) * lens_.width_px * lens_.height_px;
}

DrapeQuality DrapeJudge::take() {
  DrapeQuality out = std::exchange(sum_, {});
  if (pixels_ > 0) out.psnr_db = -10 * std::log10(std::max(1e-12, squares_ / static_cast<double>(pixels_)));
  if (windows_ > 0) out.ssim = ssim_ / static_cast<double>(windows_);
  if (!texels_px_.empty()) {
    std::sort(texels_px_.begin(), texels_px_.end());
    const auto at = [&](double part) { return texels_px_[static_cast<size_t>(part * double(texels_px_.size() - 1))]; };
    out.texel_px_p50 = at(0.5), out.texel_px_p99 = at(0.99), out.texel_px_max = at(1);
  }
  squares_ = ssim_ = 0;
  pixels_ = windows_ = 0;
  texels_px_.clear();
  return out;
}

}  // namespace foreland::lab
