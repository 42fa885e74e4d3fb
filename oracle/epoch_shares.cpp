#include "oracle/epoch_shares.h"

#include <algorithm>
#include <array>

namespace foreland::oracle {

namespace {

void addLinear(std::span<const Time> t, size_t i, double u, std::vector<double>& shares) {
  (void)t;
  shares[i] += 1 - u;
  shares[i + 1] += u;
}

void addHermite(std::span<const Time> t, size_t i, double u, std::vector<double>& shares) {
  const double step = (t[i + 1] - t[i]).toSeconds();
  const auto addSpeed = [&](size_t at, double share) {
    const size_t before = at == 0 ? 0 : at - 1, after = at + 1 == t.size() ? at : at + 1;
    const double passed = (t[after] - t[before]).toSeconds();
    shares[after] += share * step / passed;
    shares[before] -= share * step / passed;
  };
  shares[i] += (1 + 2 * u) * (1 - u) * (1 - u);
  shares[i + 1] += u * u * (3 - 2 * u);
  addSpeed(i, u * (1 - u) * (1 - u));
  addSpeed(i + 1, u * u * (u - 1));
}

// The value of the B-spline basis function of `degree` from knot k on.
double basis(std::span<const double> knots, size_t k, size_t degree, double s) {
  if (degree == 0) return knots[k] <= s && s < knots[k + 1] ? 1 : 0;
  const double rise = knots[k + degree] - knots[k], fall = knots[k + degree + 1] - knots[k + 1];
  return (rise > 0 ? (s - knots[k]) / rise * basis(knots, k, degree - 1, s) : 0) +
         (fall > 0 ? (knots[k + degree + 1] - s) / fall * basis(knots, k + 1, degree - 1, s) : 0);
}

void addSpline(std::span<const Time> t, size_t i, double u, std::vector<double>& shares) {
  const auto second = [&](size_t k) { return (t[k] - t[0]).toSeconds(); };
  std::vector<double> knots(3, 0.0);
  for (size_t k = 0; k < t.size(); ++k) knots.push_back(second(k));
  knots.insert(knots.end(), 3, knots.back());
  const double s = second(i) + u * (second(i + 1) - second(i));
  for (size_t k = 0; k + 4 < knots.size(); ++k) {
    const size_t epoch = k == 0 ? 0 : std::min(k - 1, t.size() - 1);  // the first and the last count twice
    shares[epoch] += basis(knots, k, 3, s);
  }
}

}  // namespace

std::vector<double> epochShares(std::span<const Time> epochs, proto::EpochBlend blend, Time at) {
  std::vector<double> shares(epochs.size(), 0);
  if (at <= epochs.front() || at >= epochs.back()) {
    shares[at <= epochs.front() ? 0 : epochs.size() - 1] = 1;
    return shares;
  }
  size_t i = 0;
  while (epochs[i + 1] <= at) ++i;
  const double u = (at - epochs[i]).toSeconds() / (epochs[i + 1] - epochs[i]).toSeconds();
  constexpr auto kBlends = std::array{addLinear, addHermite, addSpline};
  kBlends[static_cast<size_t>(blend)](epochs, i, u, shares);
  return shares;
}

}  // namespace foreland::oracle
