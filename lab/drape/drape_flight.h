// `foreland bench drape`: one flight over a layer of tiles, once as our server streams it and once pulled by other
// renderers' rules, over the same link and before the same judge. Deterministic.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lab/drape/drape_judge.h"
#include "lab/drape/tile_puller.h"
#include "proto/message/control.h"
#include "proto/space/path.h"
#include "server/session/world.h"
#include "sim/compute_cost.h"

namespace foreland::lab {

// Before the flight the camera stands, and the first view is sent.
inline constexpr Duration kDrapeStanding = Duration::milliseconds(5000);

struct DrapeFlight {
  std::shared_ptr<const terrain::Scene> scene;
  std::shared_ptr<const server::World> world;  // of the scene
  uint8_t layer = 0;
  proto::Path path;  // begins at kDrapeStanding
  double seconds = 60;
  proto::Lens lens{};
  proto::Predictor predictor = proto::Predictor::kKnownPath;
  double tau_px = 1;
  sim::LinkPair links{};
  sim::ComputePrices prices{};
  uint64_t seed = 1;

  proto::Pose poseAt(Time t) const { return path.at(std::max(t, path.start)); }
};

struct DrapeFigures {
  std::string way;      // foreland, or a rival's rule
  double asked_px = 0;  // the largest texel on the screen that was asked for
  uint64_t bytes = 0;   // of tiles, the first view included
  // Until the first view has what it asks for: ours what the server states (tiles for later may be among them), a
  // rival's all.
  uint64_t first_view_bytes = 0;
  DrapeQuality quality{};
  double keyframes_late = 0;  // share; ours only

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("way", way);
    visit("asked_px", asked_px);
    visit("bytes", bytes);
    visit("first_view_bytes", first_view_bytes);
    visit("psnr_db", quality.psnr_db);
    visit("ssim", quality.ssim);
    visit("texel_px_p50", quality.texel_px_p50);
    visit("texel_px_p99", quality.texel_px_p99);
    visit("texel_px_max", quality.texel_px_max);
    visit("blur_px_s", quality.blur_px_s);
    visit("texels_over_stated", quality.over_stated);
    visit("not_drawn", quality.not_drawn);
    visit("jumped_pixels", quality.jumped_pixels);
    visit("keyframes_late", keyframes_late);
  }
};

// What tiles do to the geometry, which shares the link with them.
struct DrapeArrivals {
  double first_picture_ms = 0;  // from the connection to the first frame that shows a mesh
  double tolerance_ms = 0;      // and to the first one within the tolerance asked for
  double lateness_p99_ms = 0;   // of keyframes; negative is early

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("first_picture_ms", first_picture_ms);
    visit("tolerance_ms", tolerance_ms);
    visit("lateness_p99_ms", lateness_p99_ms);
  }
};

class DrapeExperiment {
 public:
  struct Ours {
    DrapeFigures figures;
    DrapeArrivals arrivals;
  };

  // An Error if the scene does not fit into memory. `every_s` apart frames are judged.
  static Result<DrapeExperiment> create(const DrapeFlight& flight, double every_s);

  Ours flyOurs();
  // Of our flight without any tiles.
  DrapeArrivals flyWithoutTiles() const;
  DrapeFigures pull(TileRule rule, double texel_px);
  // With the texel size at which it is nearest to this PSNR, if there is one between 0.25 and 16 px; bytes are
  // interpolated between the two sizes next to it.
  DrapeFigures pullForPsnr(TileRule rule, double psnr_db);

 private:
  DrapeExperiment(const DrapeFlight& flight, DrapeJudge judge, double every_s)
      : flight_(flight), judge_(std::move(judge)), image_(flight.scene, flight.layer), every_s_(every_s) {}
  Time judgedAt(size_t frame) const;
  Time end() const { return Time{} + kDrapeStanding + Duration::seconds(flight_.seconds); }

  DrapeFlight flight_;
  DrapeJudge judge_;
  LayerImage image_;
  double every_s_;
};

}  // namespace foreland::lab
