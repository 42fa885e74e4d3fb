// What a flight looks like where tiles are drawn, against the finest tiles there are: the ground that pixels show is
// found by rays on all heights of the scene, so neither the mesh nor any choice of tiles plays a part in it. Shares no
// code with the selection. One owner.
#pragma once

#include <memory>
#include <vector>

#include "base/result.h"
#include "lab/drape/layer_image.h"
#include "proto/space/pose.h"
#include "sim/client_drape.h"
#include "terrain/render/ray_caster.h"

namespace foreland::lab {

struct DrapeQuality {
  double psnr_db = 0, ssim = 0;  // of brightness
  // Of the texels that are drawn, on the screen, where the data have finer ones.
  double texel_px_p50 = 0, texel_px_p99 = 0, texel_px_max = 0;
  double blur_px_s = 0;      // pixels whose texels are larger than kBlur_px, times seconds
  uint64_t over_stated = 0;  // samples whose texels are larger than was stated
  uint64_t not_drawn = 0;    // samples of no tile
  double jumped_pixels = 0;  // whose level changed at once, all such changes together
};

class DrapeJudge {
 public:
  static constexpr double kBlur_px = 2.02;

  // A frame from each of these poses stands for `seconds` of flight. An Error if the scene does not fit into memory.
  static Result<DrapeJudge> create(const std::shared_ptr<const terrain::Scene>& scene, const proto::Lens& lens,
                                   std::vector<proto::Pose> poses, double seconds);

  size_t frames() const { return poses_.size(); }
  // Judges what is drawn in frame i.
  void judge(size_t frame, LayerImage& image, const sim::DrawnTiles& drawn, double stated_px);
  // Counts the pixels of frame i at which `after` shows another level than `before` did, where that showed any. From a
  // few pixels of each block.
  void compare(size_t frame, const LayerImage& image, const sim::DrawnTiles& before, const sim::DrawnTiles& after);
  // Of all frames judged or compared since the last call.
  DrapeQuality take();

 private:
  struct Sample {
    glm::dvec2 lattice{0, 0};
    float pixel = 0;  // of the ground that a pixel covers there: sample intervals, the root of its area
  };
  using Block = std::vector<Sample>;  // pixel by pixel; a sample that hits nothing has pixel 0

  DrapeJudge(terrain::RayCaster caster, std::shared_ptr<const terrain::Scene> scene, const proto::Lens& lens,
             std::vector<proto::Pose> poses, double seconds);
  const std::vector<Block>& samples(size_t frame);
  Block cast(const proto::Pose& pose, uint32_t left, uint32_t top) const;

  terrain::RayCaster caster_;
  std::shared_ptr<const terrain::Scene> scene_;
  proto::Lens lens_;
  std::vector<proto::Pose> poses_;
  double seconds_;
  std::vector<std::vector<Block>> samples_;                 // by frame, once cast
  std::vector<std::vector<std::vector<float>>> reference_;  // brightness, by frame, block and pixel

  double squares_ = 0, ssim_ = 0;
  uint64_t pixels_ = 0, windows_ = 0;
  std::vector<float> texels_px_;
  DrapeQuality sum_;
};

}  // namespace foreland::lab
