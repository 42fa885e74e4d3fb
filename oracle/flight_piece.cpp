#include "oracle/flight_piece.h"

#include <algorithm>
#include <cmath>

namespace foreland::oracle {

FlightJudgement FlightJudge::judge(const FlightPiece& piece) {
  FlightJudgement found{.frame = piece.frame};
  if (piece.looks_for_cracks) found.cracks = oracle_.findCracks(*piece.mesh, piece.shape);
  if (piece.keyframe) judgeKeyframe(piece, found);
  if (piece.shown) judgeFrame(piece, found);
  if (piece.motion) measureMotion(piece, found);
  return found;
}

FlightJudge::Drawn FlightJudge::drawn(const FlightPiece& piece, const proto::Pose& asked, const proto::Lens& lens) {
  const client::Exaggeration& e = piece.exaggeration;
  return e.factor == 1 ? Drawn{asked, lens} : Drawn{e.drawnPose(asked), e.drawn};
}

void FlightJudge::judgeKeyframe(const FlightPiece& piece, FlightJudgement& found) {
  const client::KeyframeMesh& mesh = *piece.mesh;
  const Drawn camera = drawn(piece, mesh.to.pose, mesh.to.lens);
  const double tolerance_px = piece.exaggeration.finer * mesh.to.frameTolerance();
  found.keyframe = oracle_.error(mesh, 1, camera.pose, camera.lens, tolerance_px);
  found.is_keyframe_over_tolerance = found.keyframe->max_px > tolerance_px + kSlack_px;
  if (!piece.keyframe->exact) return;
  const DrawnShare newest{.mesh = &mesh, .weight = 1}, exact{.mesh = piece.keyframe->exact->mesh(section_at_).get()};
  const Drawn wanted = drawn(piece, piece.keyframe->true_pose, piece.lens);
  found.extrapolation = oracle_.difference({&newest, 1}, {&exact, 1}, wanted.pose, wanted.lens);
}

void FlightJudge::judgeFrame(const FlightPiece& piece, FlightJudgement& found) {
  const FlightPiece::Frame& frame = *piece.shown;
  const Drawn camera = drawn(piece, frame.pose, piece.lens);
  const double tolerance_px = piece.exaggeration.finer * frame.tolerance_px;
  found.shown = oracle_.error(*piece.mesh, frame.weight, camera.pose, camera.lens, tolerance_px);
  found.weight = frame.weight;
  found.is_outside = frame.is_outside;
  found.is_over_tolerance = found.shown->max_px > tolerance_px + kSlack_px;
  if (frame.terms) measureTerms(piece, *frame.terms, found);
}

void FlightJudge::measureTerms(const FlightPiece& piece, const FlightPiece::Terms& terms, FlightJudgement& found) {
  const FlightPiece::Frame& frame = *piece.shown;
  const Drawn camera = drawn(piece, frame.pose, piece.lens);
  const auto difference = [&](Surface a, const client::KeyframeMesh& b) {
    const DrawnShare whole{.mesh = &b};
    return oracle_.difference(a, {&whole, 1}, camera.pose, camera.lens);
  };
  const FlightPiece::Mesh shown = section_at_(terms.shown);
  if (terms.from) {
    const DrawnShare between[] = {{.mesh = terms.from->mesh(section_at_).get(), .share = 1.0 - frame.weight},
                                  {.mesh = terms.to->mesh(section_at_).get(), .share = frame.weight}};
    found.interpolation = difference(between, *shown);
  } else {
    const DrawnShare drawn{.mesh = piece.mesh.get(), .weight = frame.weight};
    found.interpolation = difference({&drawn, 1}, *shown);
  }
  if (!terms.current) return;
  const FlightPiece::Mesh current = section_at_(*terms.current);
  const DrawnShare current_share{.mesh = current.get()};
  found.view = difference({&current_share, 1}, *shown);
}

void FlightJudge::measureMotion(const FlightPiece& piece, FlightJudgement& found) const {
  const FlightPiece::Motion& motion = *piece.motion;
  const Drawn camera = drawn(piece, motion.pose, piece.lens);
  const size_t seen =
      collectLodMotion(*piece.mesh, motion.weights, camera.pose, camera.lens, found.moved_px, oracle_.stretch());
  Deviation& all = found.motion.emplace();
  double sum2 = 0;
  for (double& px : found.moved_px) {
    px /= 60 * motion.seconds;
    all.max_px = std::max(all.max_px, px);
    sum2 += px * px;
  }
  all.rms_px = std::sqrt(sum2 / static_cast<double>(std::max<size_t>(seen, 1)));
}

}  // namespace foreland::oracle
