// Which of the frames that are shown are judged, and with which weights between their keyframes that was. Judging every
// sixth of twelve frames a keyframe would see the weights 0 and 1/2 only; with a stride that shares no factor with the
// frames per keyframe every weight has its turn. Pure.
#pragma once

#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>

namespace foreland::oracle {

// The least stride from `at_least` on that shares no factor with the frames per keyframe. Both are positive.
inline uint32_t coprimeStride(uint32_t at_least, uint32_t frames_per_keyframe) {
  while (std::gcd(at_least, frames_per_keyframe) != 1) ++at_least;
  return at_least;
}

class JudgedWeights {
 public:
  void add(double weight) { thousandths_.insert(static_cast<int>(std::lround(1000 * weight))); }
  size_t distinct() const { return thousandths_.size(); }  // to a thousandth
  double least() const { return thousandths_.empty() ? 0 : *thousandths_.begin() / 1000.0; }
  double largest() const { return thousandths_.empty() ? 0 : *thousandths_.rbegin() / 1000.0; }

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("distinct", distinct());
    visit("least", least());
    visit("largest", largest());
  }

 private:
  std::set<int> thousandths_;
};

}  // namespace foreland::oracle
