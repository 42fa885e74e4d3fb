#include "lab/latency/figures.h"
#include "base/quantile.h"

#include <algorithm>
#include <cmath>

namespace foreland::lab {

namespace {

constexpr double kRounding_px = 0.01;  // rounding of positions and poses, as in flight_truth.cpp

TermFigures termOf(const std::vector<FrameTerms>& frames, Term term) {
  TermFigures result;
  std::vector<double> px, m;
  for (const FrameTerms& frame : frames) {
    const oracle::Deviation& d = frame.of(term);
    px.push_back(d.max_px);
    m.push_back(d.max_m);
    result.mean_px += d.max_px;
    result.mean_m += d.max_m;
    result.rms_px += d.rms_px * d.rms_px;
    result.rms_m += d.rms_m * d.rms_m;
  }
  const double n = static_cast<double>(std::max<size_t>(frames.size(), 1));
  result.mean_px /= n, result.mean_m /= n;
  result.rms_px = std::sqrt(result.rms_px / n), result.rms_m = std::sqrt(result.rms_m / n);
  result.max_px = quantile(px, 1), result.p99_px = quantile(px, 0.99);
  result.max_m = quantile(m, 1), result.p99_m = quantile(m, 0.99);
  return result;
}

void countJudged(const CellFlight& flight, CellFigures& out) {
  std::vector<double> motion_px;
  for (const FrameTerms& frame : flight.frames) {
    out.bound_violations += frame.breaks_bound;
    out.over_tau += frame.of(Term::kTotal).max_px > flight.cell.tau_px + kRounding_px;
    out.over_stated += frame.of(Term::kTotal).max_px > frame.tolerance_px + kRounding_px;
    motion_px.push_back(frame.lod_motion_px);
  }
  out.lod_motion_p99_px = quantile(motion_px, 0.99);
  out.lod_motion_max_px = quantile(motion_px, 1);
}

void countShown(const ShownFrames& shown, CellFigures& out) {
  const double n = static_cast<double>(std::max<uint64_t>(shown.count, 1));
  out.frames = shown.count;
  out.outside = shown.outside;
  out.triangles = static_cast<double>(shown.triangles) / n;
  out.delay_mean_ms = shown.delay_ms / n;
  out.delay_max_ms = shown.delay_max_ms;
  out.stated_mean_px = shown.tolerance_px / static_cast<double>(std::max<uint64_t>(shown.count - shown.outside, 1));
  out.stated_max_px = shown.tolerance_max_px;
}

void countKeyframes(const CellFlight& flight, CellFigures& out) {
  std::vector<double> lateness_ms, compute_ms;
  for (const FlownKeyframe& k : flight.keyframes) {
    lateness_ms.push_back(k.lateness_ms);
    compute_ms.push_back(k.compute_ms);
    out.compute_mean_ms += k.compute_ms;
    out.late += k.lateness_ms > 0;
  }
  out.keyframes = flight.keyframes.size();
  out.compute_mean_ms /= static_cast<double>(std::max<size_t>(out.keyframes, 1));
  out.lateness_p99_ms = quantile(lateness_ms, 0.99);
  out.lateness_max_ms = quantile(lateness_ms, 1);
  out.compute_p99_ms = quantile(compute_ms, 0.99);
}

}  // namespace

CellFigures figuresOf(const CellFlight& flight, double seconds) {
  CellFigures out;
  out.cell = flight.cell;
  for (size_t i = 0; i < kTerms; ++i) out.terms[i] = termOf(flight.frames, static_cast<Term>(i));
  out.judged = flight.frames.size();
  out.bytes_down = flight.bytes_down;
  out.bytes_up = flight.bytes_up;
  out.down_kbit_s = 8e-3 * static_cast<double>(flight.bytes_down) / seconds;
  countShown(flight.shown, out);
  countJudged(flight, out);
  countKeyframes(flight, out);
  return out;
}

}  // namespace foreland::lab
