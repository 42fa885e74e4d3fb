#include "apps/fly/afterwards.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "apps/exact_sections.h"
#include "apps/fly/globe_sources.h"
#include "apps/options/options.h"
#include "apps/report/progress_line.h"
#include "apps/stop_signal.h"
#include "oracle/scene_truth.h"
#include "server/sight/triangle_tree.h"
#include "terrain/render/ray_caster.h"

namespace foreland::apps {

void addAfterwardsOptions(CLI::App& app, AfterwardsOptions& o) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("The report");
  };
  CLI::Option* truth = add("--truth", o.truth, "measure errors against this scene file, the one that is served");
  truth->type_name(file("SCENE.fls"));
  add("--truth-every", o.truth_every,
      "measure one in N frames, more if N shares a factor with the frames per keyframe; keyframes always")
      ->type_name(whole("N"))
      ->needs(truth)
      ->check(within(1u, 1'000'000u))
      ->capture_default_str();
  add("--truth-frames", o.truth_frames,
      "measure at most about N frames, and as many keyframes, evenly over the flight; 0: all that --truth-every gives, "
      "and all keyframes")
      ->type_name(whole("N"))
      ->needs(truth)
      ->check(within(0u, 1'000'000u))
      ->capture_default_str();
  add("--truth-terms-every", o.truth_terms_every,
      "measure the terms of the error, for which sections are computed anew, in one of N measured frames and "
      "keyframes; "
      "0: in none; by default 1 with --json, otherwise 0")
      ->type_name(whole("N"))
      ->needs(truth)
      ->check(within(0u, 1'000'000u));
  add("--threads", o.threads, "that measure; 0 for one per processor")
      ->type_name(whole("N"))
      ->needs(truth)
      ->check(within(0u, 1024u))
      ->capture_default_str();
  CLI::Option* source = add(
      "--source", o.sources,
      "of a globe, a file that it was made of, perhaps with @vertical=... as for `foreland build`; all are to be "
      "given. "
      "What is drawn is measured against their samples, too: no further off on the screen than the tolerance and what "
      "the residual that the scene states looks like");
  source->type_name(file("FILE"))->needs(truth)->allow_extra_args(false);
  addAllowedFolders(app, o.foreign)->group("The report")->needs(source);
  CLI::Option* dump =
      add("--dump", o.dump,
          "write what is drawn into this folder, after landing: a PLY mesh in metres, and a line in frames.jsonl");
  dump->type_name(folder("DIR"));
  add("--dump-every", o.dump_every, "dump every Nth frame")
      ->type_name(whole("N"))
      ->needs(dump)
      ->check(within(1u, 1'000'000u))
      ->capture_default_str();
}

Result<Afterwards> Afterwards::prepare(const AfterwardsOptions& options) {
  Afterwards afterwards;
  afterwards.options_ = options;
  if (!options.truth.empty()) {
    auto scene = terrain::Scene::open(options.truth);
    if (!scene.ok()) return scene.error();
    afterwards.truth_ = *scene;
    auto oracle = oracle::sceneOracle(*scene);
    if (!oracle.ok()) return oracle.error();
    afterwards.oracle_.emplace(std::move(oracle).value());
    if (!options.sources.empty()) {
      auto sources = sourceOracle(**scene, options.sources, options.foreign);
      if (!sources.ok()) return sources.error();
      afterwards.oracle_->judgeSources(std::move(sources).value());
    }
  }
  if (!options.dump.empty()) {
    auto dump = client::FrameDump::create(options.dump);
    if (!dump.ok()) return dump.error();
    afterwards.dump_ = std::move(dump).value();
  }
  return afterwards;
}

Status Afterwards::checkScene(const client::Viewer& viewer) const {
  const auto& welcome = viewer.welcome();
  if (!welcome || !truth_ || welcome->scene_id == truth_->id()) return {};
  return Error{ErrorCode::kInvalidArgument, "--truth " + options_.truth.string() +
                                                " is not the scene that the server shows ('" + welcome->title +
                                                "'); name that scene's file"};
}

namespace {

// A globe whose ground lines of sight meet.
struct Body {
  explicit Body(std::shared_ptr<const terrain::Scene> scene) : hierarchy(std::move(scene)), ground(hierarchy) {}
  server::Hierarchy hierarchy;
  server::TriangleTree ground;
};

}  // namespace

// Where what is hidden may be left out, only what is seen is judged: by rays on the scene at full resolution.
void Afterwards::judgeOnlySeen() {
  constexpr double kGrazing_m = 0.05;  // more than floats round positions by
  if (truth_->grid().isCube())
    return oracle_->judgeOnlySeen(
        [body = std::make_shared<const Body>(truth_)](const glm::dvec3& point, const glm::dvec3& eye) {
          const double distance_m = glm::distance(point, eye);
          if (distance_m <= kGrazing_m) return true;
          const server::SightLine line(body->hierarchy.frame().transform(), eye, point, 0);
          uint64_t work = 0;
          return !body->ground.meet(line, server::TriangleTree::Wanted::kAny, 1 - kGrazing_m / distance_m, {}, work);
        });
  auto rays = terrain::RayCaster::ofScene(truth_);
  if (!rays) return;
  const auto caster = std::make_shared<const terrain::RayCaster>(std::move(*rays));
  oracle_->judgeOnlySeen([caster](const glm::dvec3& point, const glm::dvec3& eye) {
    const glm::dvec3 way = point - eye;
    const double distance_m = glm::length(way);
    return distance_m <= kGrazing_m || !caster->hit({eye, way / distance_m, distance_m - kGrazing_m});
  });
}

std::optional<oracle::FlightTruth> Afterwards::measure(const client::FlightLog& log, uint32_t terms_every) {
  if (!truth_) return std::nullopt;
  if (log.options.request.occlusion) judgeOnlySeen();
  ProgressLine line;
  const auto tell = [&line](double share) {
    line.show("judging frames", share);
    return !isStopRequested();
  };
  const oracle::FlightTruth truth =
      oracle::measureFlight(log, *oracle_,
                            {.frame_every = options_.truth_every,
                             .max_frames = options_.truth_frames,
                             .sections = truth_->grid().isCube() ? nullptr : exactSectionsOf(truth_),
                             .terms_every = options_.truth_terms_every.value_or(terms_every),
                             .threads = options_.threads,
                             .on_progress = tell});
  if (truth.is_whole) line.show("judging frames", 1);
  line.end();
  return truth;
}

Result<uint64_t> Afterwards::dump(const client::FlightLog& log) {
  if (!dump_) return uint64_t{0};
  Status status;
  uint64_t number = 0;
  client::replay(log, [&](const client::Player& player, Time now) {
    if (player.phase() != client::Player::Phase::kFlying && player.phase() != client::Player::Phase::kDone) return true;
    const client::FrameView& view = player.view();
    const uint64_t n = number++;
    if (n % options_.dump_every != 0 || !view.mesh) return true;
    status =
        dump_->write({n, (now - player.path().start).toSeconds(), (view.shown_time - player.path().start).toSeconds()},
                     view, log.options.request);
    return status.ok();
  });
  if (!status.ok()) return status.error();
  return dump_->written();
}

}  // namespace foreland::apps
