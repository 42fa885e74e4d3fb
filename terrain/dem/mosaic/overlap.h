// Whether two inputs tell the same heights where they overlap, and if not what is likely wrong with them. One owner.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace foreland::terrain {

// Of two heights of the same samples, at most so many pairs that are spread evenly over all.
class Overlap {
 public:
  static constexpr size_t kMostPairs = 1u << 14, kFewestPairs = 16;
  static constexpr double kDoubtful_m = 100;

  void add(float first_m, float second_m) {
    if (seen_++ % stride_ == 0) keep(first_m, second_m);
  }

  // What is likely wrong, as the end of a sentence, if the median difference is more than kDoubtful_m.
  std::optional<std::string> doubt() const;

 private:
  struct Pair {
    float first_m, second_m;
  };
  void keep(float first_m, float second_m);

  std::vector<Pair> pairs_;
  size_t seen_ = 0, stride_ = 1;
};

}  // namespace foreland::terrain
