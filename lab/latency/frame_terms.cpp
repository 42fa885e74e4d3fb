#include "lab/latency/frame_terms.h"

#include <cmath>

#include "lab/latency/section_chain.h"

namespace foreland::lab {

namespace {

// Positions are floats, and their differences err by some micrometres near the eye.
constexpr double kSlack_px = 0.01, kSlack_m = 1e-3;

// Whether `total` is at most the sum of the other terms, in every norm.
bool isBounded(const FrameTerms& frame) {
  oracle::Deviation sum;
  for (size_t i = 1; i < kTerms; ++i) {
    const oracle::Deviation& d = frame.terms[i];
    sum.max_px += d.max_px, sum.rms_px += d.rms_px, sum.max_m += d.max_m, sum.rms_m += d.rms_m;
  }
  const oracle::Deviation& total = frame.of(Term::kTotal);
  return total.max_px <= sum.max_px + kSlack_px && total.rms_px <= sum.rms_px + kSlack_px &&
         total.max_m <= sum.max_m + kSlack_m && total.rms_m <= sum.rms_m + kSlack_m;
}

}  // namespace

const char* name(Term term) {
  constexpr const char* kNames[kTerms] = {"total", "refinement", "interpolation", "view", "extrapolation"};
  return kNames[static_cast<size_t>(term)];
}

FrameJudge::FrameJudge(Flight flight, oracle::Oracle& oracle)
    : flight_(std::move(flight)),
      oracle_(oracle),
      shown_(sectionChain(flight_.world)),
      current_(sectionChain(flight_.world)),
      keyframes_(sectionChain(flight_.world)) {}

FrameJudge::Mesh FrameJudge::viewAt(const oracle::SectionAt& chain, Time t) const {
  return chain({.pose = flight_.path->at(t), .lens = flight_.lens, .tau_px = flight_.tau_px});
}

FrameJudge::Mesh FrameJudge::trueKeyframe(const proto::KeyframeHeader& header) {
  return true_keyframes_.at(flight_.path->at(header.time), flight_.lens, header)->mesh(keyframes_);
}

FrameTerms FrameJudge::judge(const client::FrameView& view, Time now) {
  constexpr size_t kDrawn = 0, kShown = 1, kThird = 2;
  const Mesh shown = viewAt(shown_, view.shown_time);
  Mesh current, from, to;
  const oracle::DrawnShare drawn_share{.mesh = view.mesh, .weight = view.weight}, shown_share{.mesh = shown.get()};
  std::array<oracle::DrawnShare, 2> third_shares;
  std::vector<oracle::Surface> surfaces{{&drawn_share, 1}, {&shown_share, 1}};
  std::vector<oracle::SurfacePair> pairs{{kDrawn, oracle::SurfacePair::kTruth}};
  std::vector<Term> terms{Term::kTotal};
  const auto add = [&](Term term, oracle::SurfacePair pair) {
    terms.push_back(term);
    pairs.push_back(pair);
  };
  switch (flight_.strategy) {
    case proto::Strategy::kDelay:
      add(Term::kRefinement, {kShown});
      add(Term::kInterpolation, {kDrawn, kShown});
      break;
    case proto::Strategy::kCurrent:
      current = viewAt(current_, now);
      third_shares[0] = {.mesh = current.get()};
      surfaces.push_back({third_shares.data(), 1});
      add(Term::kRefinement, {kThird});
      add(Term::kView, {kThird, kShown});
      add(Term::kInterpolation, {kDrawn, kShown});
      break;
    case proto::Strategy::kPredict:
      from = trueKeyframe(view.mesh->from);
      to = trueKeyframe(view.mesh->to);
      third_shares = {oracle::DrawnShare{.mesh = from.get(), .share = 1.0 - view.weight},
                      oracle::DrawnShare{.mesh = to.get(), .share = view.weight}};
      surfaces.push_back(third_shares);
      add(Term::kRefinement, {kShown});
      add(Term::kInterpolation, {kThird, kShown});
      add(Term::kExtrapolation, {kDrawn, kThird});
      break;
  }
  FrameTerms frame{.time_s = (now - flight_.path->start).toSeconds(),
                   .weight = view.weight,
                   .delay_ms = (now - view.shown_time).toMilliseconds(),
                   .triangles = view.mesh->triangleCount(),
                   .tolerance_px = view.tolerance_px};
  const std::vector<oracle::Deviation> found = oracle_.compare(surfaces, pairs, view.pose, flight_.lens);
  for (size_t i = 0; i < terms.size(); ++i) frame.terms[static_cast<size_t>(terms[i])] = found[i];
  frame.breaks_bound = !isBounded(frame);
  return frame;
}

}  // namespace foreland::lab
